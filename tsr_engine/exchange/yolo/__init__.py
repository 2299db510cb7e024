"""YOLO as Ultralytics reads it: a text file a picture, ``class cx cy w h`` in parts of the picture.

A sixth column would make Ultralytics drop the picture, so tracks go into ``tracks.csv`` beside, which names each line
of each label file. Source: docs.ultralytics.com, datasets/detect; ``ultralytics/data/utils.py``.
"""
