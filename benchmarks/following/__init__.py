"""Following signs that are drawn once: by ours, by peers, and by straight lines."""
