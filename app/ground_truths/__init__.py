"""Ground truth of videos: imported from CSV, shown as a layer, compared with runs."""
