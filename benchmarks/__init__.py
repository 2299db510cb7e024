"""Measurements: one module for each experiment, results as JSON, and one report from the results."""
