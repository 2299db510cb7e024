"""Videos, identified by their content; their frames, by ordinal."""
