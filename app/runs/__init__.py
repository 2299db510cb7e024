"""Runs of the engine: start, follow, cancel, resume, remove."""
