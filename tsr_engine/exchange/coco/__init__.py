"""COCO detection: one JSON file a subset; tracks by the attributes ``track_id`` and ``keyframe``, as CVAT has them.

Boxes are ``x, y, width, height`` in px from 0; category and image ids count from 1. A place to ignore is a crowd.
The reader takes a flat list of results (``image_id, category_id, bbox, score``) as detections. Source: cocodataset.org,
format-data; attributes: ``format-coco.md`` of CVAT's documentation.
"""
