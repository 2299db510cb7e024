"""Finds videos by what their tracks are."""
