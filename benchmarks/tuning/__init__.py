"""Commands that compare parameter values, on data without reported figures: ``python -m benchmarks.tuning.NAME``."""
