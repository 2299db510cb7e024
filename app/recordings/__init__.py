"""Recordings for the Rerun viewer, and the viewer itself, served from this server."""
