"""The search across videos: an index of all tracks, questions to it, and what is done with what was found."""
