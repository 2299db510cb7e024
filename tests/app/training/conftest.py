"""Makes the shared toys importable."""
