"""Datumaro JSON: one file a subset, one item a picture; tracks by the attributes ``track_id`` and ``keyframe``.

Boxes are ``x, y, width, height`` in px from 0. The form is that of Datumaro's own exporter, format version 1.0.
"""
