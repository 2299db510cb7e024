"""Evaluation: matching, scores and plots."""
