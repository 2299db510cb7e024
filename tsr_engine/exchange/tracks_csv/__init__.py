"""Reads and writes CSV of tracks: the layouts of ``tsr track --csv`` and of ground truth, and those of other trackers.

Edges are px from 0, frames count from 0. The default layout is that of ``tsr track`` with more columns at the end, so
readers of that layout read these files too.
"""
