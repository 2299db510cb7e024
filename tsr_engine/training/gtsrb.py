"""GTSRB for the trainers: the reader of ``tsr_engine.io.gtsrb`` under the name beside ``gtsdb``."""

from __future__ import annotations

from tsr_engine.io.gtsrb import CropItem, read_items, read_picture, read_table, split_by_track, tracks_of

__all__ = ["CropItem", "read_items", "read_picture", "read_table", "split_by_track", "tracks_of"]
