"""Comparison with other trackers: all get the same detections and the same figures.

The product does not need this package. A peer whose package is not installed raises ``Missing``.
"""
