"""Annotations of drive videos to and from the formats of other tools."""
