"""YOLO as Ultralytics reads it: a text file a picture, ``class cx cy w h`` in parts of the picture.

A sixth column would make Ultralytics drop the picture. So ``tracks.csv`` beside the label files names the track of each
of their lines. Source: docs.ultralytics.com, datasets/detect; ``ultralytics/data/utils.py``.
"""
