"""Files: video, pictures, models, tables."""
