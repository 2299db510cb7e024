"""tsr: traffic signs in drive videos, with the evidence behind every box and label.

The method is that of Yuan, Xiong and Wang, "An Incremental Framework for Video-Based Traffic Sign Detection,
Tracking, and Recognition", IEEE T-ITS 18(7), 2017.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tsr_engine.version import __version__

if TYPE_CHECKING:
    from tsr_engine.online.incremental_svm import IncrementalSVC

__all__ = ["IncrementalSVC", "__version__"]


def __getattr__(name: str) -> object:
    # Imported on first use, because importing Numba takes long.
    if name == "IncrementalSVC":
        from tsr_engine.online.incremental_svm import IncrementalSVC

        return IncrementalSVC
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
