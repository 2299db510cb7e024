"""Ground truth of videos: imported from CSV, drawn as a layer, compared against."""
