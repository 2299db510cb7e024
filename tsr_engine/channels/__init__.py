"""Aggregated channel features and their pyramid."""
