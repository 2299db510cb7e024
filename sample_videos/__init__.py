"""A procedural road drive with exact truth, and two short clips made by it."""
