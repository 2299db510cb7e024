"""A small deep detector, trained from scratch on the scenes of the report, and networks for comparison of times."""
