"""Reads evidence for the page: tracks, lanes, overlays, crops and explanations."""
