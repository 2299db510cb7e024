"""Label sets of a library: which labels its videos, runs and corrections have."""
