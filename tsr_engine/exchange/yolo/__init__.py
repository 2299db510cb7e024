"""YOLO as Ultralytics reads it: one text file per picture, ``class cx cy w h`` in relative coordinates.

A sixth column makes Ultralytics drop the picture, so ``tracks.csv`` beside the label files names the track of each
line. Source: docs.ultralytics.com, datasets/detect; ``ultralytics/data/utils.py``.
"""
