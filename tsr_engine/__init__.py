"""tsr: traffic signs in drive videos, with the evidence behind every box and label.

The method is that of Yuan, Xiong and Wang, "An Incremental Framework for Video-Based Traffic Sign Detection,
Tracking, and Recognition", IEEE T-ITS 18(7), 2017.
"""

from tsr_engine.version import __version__

__all__ = ["__version__"]
