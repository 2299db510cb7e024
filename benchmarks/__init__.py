"""Measurements: one module an experiment, results as JSON, one report written from them."""
