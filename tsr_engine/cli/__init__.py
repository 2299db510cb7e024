"""The command `tsr`."""
