"""Reads and writes plain JSON of tracks or detections, for other detectors and trackers and for lossless copies.

::

    {"format": "tsr-tracks", "version": 1, "video": {...}, "classes": ["stop", ...],
     "tracks": [{"id": "m7", "class": "stop", "state": "open", "source": "engine", "notes": [[12, "lamp?"]],
                 "attributes": {"lit": true},
                 "boxes": [{"frame": 10, "box": [x1, y1, x2, y2], "score": 0.9, "key": true, "attributes": {}}, ...]}],
     "detections": [{"frame": 10, "box": [x1, y1, x2, y2], "class": "stop", "score": 0.9}],
     "negatives": [{"id": "m9", ...}]}

``negatives`` are rejected tracks in the form of ``tracks``.
Edges are px from 0, frames count from 0. The reader also takes a bare list of tracks or detections.
"""
