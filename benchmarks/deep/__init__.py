"""A small deep detector trained from scratch on the scenes of the report, and the networks it is timed beside."""
