"""The search across videos: an index of all tracks, queries, and actions on the results."""
