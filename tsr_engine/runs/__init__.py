"""Runs: a video through the engine, live or replayed from evidence, with what it writes and reports."""
