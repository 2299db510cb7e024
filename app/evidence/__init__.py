"""What the page reads from evidence: tracks, lanes, overlays, crops, and why."""
