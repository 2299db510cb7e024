"""The check of a bundle, inside a cage."""

from __future__ import annotations

import resource
from pathlib import Path
from typing import Final

from app.cages.talk import Talk
from tsr_engine.bundle.check import check_and_unpack
from tsr_engine.bundle.load import Bundle
from tsr_engine.errors import ImportFormatError
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.json_shapes import JsonObject

__all__ = ["check_bundle"]

_ONCE: Final = 20
"""Seconds of computing for any clip."""
_FRAME: Final = 0.2
"""Further seconds for each frame, whatever its size."""
_PIXEL: Final = 1e-7
"""Further seconds for each pixel: ten times the time to decode it, hash it and read its evidence."""


def check_bundle(talk: Talk, path: Path, folder: Path, limits: VideoLimits) -> JsonObject:
    """Check and unpack a bundle (``tsr_engine.bundle.check.check_and_unpack``); the clip's length limits the computing.

    Raises:
        ImportFormatError: the bundle cannot be read or breaks a rule.
    """

    def afford(bundle: Bundle) -> None:
        clip, frames = bundle.manifest.clip, bundle.manifest.frames
        seconds = _ONCE + (frames.stop - clip.offset) * (_FRAME + _PIXEL * clip.width * clip.height)
        used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
        most = resource.getrlimit(resource.RLIMIT_CPU)[1]
        computing = int(used + seconds) if most == resource.RLIM_INFINITY else min(int(used + seconds), most)
        resource.setrlimit(resource.RLIMIT_CPU, (computing, computing))
        talk.send({"frames": frames.stop - frames.start})

    try:
        return check_and_unpack(path, folder, limits, afford)
    except (KeyError, TypeError, AttributeError, ValueError, OverflowError, RecursionError) as error:
        raise ImportFormatError(
            f"{path.name} cannot be read ({type(error).__name__}). Make the bundle anew."
        ) from error
