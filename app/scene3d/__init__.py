"""Three-dimensional views of a run: the space-time volume, the spatial prior, the metric drive."""
