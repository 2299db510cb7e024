"""Plain CSV of tracks: the layout of ``tsr track --csv``, that of ground truth, and what other trackers write.

Edges are px from 0, frames count from 0. The default layout is that of ``tsr track`` with more columns at its end, so
that every reader of those rows reads these too.
"""
