"""Measures, scores and plots."""
