"""Reviewed drives as a regression suite for models and parameters. See docs/check.md."""
