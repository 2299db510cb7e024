"""Pictures, videos and detections as of worse cameras, weather and detectors."""
