"""Other people's trackers beside ours: the same detections in, the same figures out.

Nothing here is needed to run the product. A peer whose package is not installed says so by name (``Missing``).
"""
