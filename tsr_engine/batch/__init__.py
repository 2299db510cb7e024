"""Tracks many drives in one call, each in its own process, on this machine or a Ray cluster. See docs/batch.md."""
