"""Runs and annotations to and from the formats of other tools."""
