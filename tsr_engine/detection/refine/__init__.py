"""The refine-and-verify stage: what happens to a candidate after the scan of the cascade."""
