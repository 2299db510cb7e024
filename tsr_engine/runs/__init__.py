"""Runs of the engine over a video, live or replayed from evidence, with their outputs and reports."""
