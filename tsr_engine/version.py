"""The version of the engine, recorded with every run, model and evidence store."""

__version__ = "0.2.0"
