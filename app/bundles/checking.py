"""The check of a bundle, inside a sandbox."""

from __future__ import annotations

import resource
from pathlib import Path
from typing import Final

from app.sandbox.channel import Channel
from tsr_engine.bundle.check import check_and_unpack
from tsr_engine.bundle.load import Bundle
from tsr_engine.errors import ImportFormatError
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.json_shapes import JsonObject

_BASE_SECONDS: Final = 20
"""Seconds of computing for any clip."""
_SECONDS_PER_FRAME: Final = 0.2
"""Further seconds for each frame, whatever its size."""
_SECONDS_PER_PIXEL: Final = 1e-7
"""Further seconds for each pixel: ten times the time to decode it, hash it and read its evidence."""


def check_bundle(channel: Channel, path: Path, folder: Path, limits: VideoLimits) -> JsonObject:
    """Check and unpack a bundle (``tsr_engine.bundle.check.check_and_unpack``); the clip's length limits the computing.

    Raises:
        ImportFormatError: the bundle cannot be read or breaks a rule.
    """

    def limit_computing(bundle: Bundle) -> None:
        clip, frames = bundle.manifest.clip, bundle.manifest.frames
        seconds = _BASE_SECONDS + (frames.stop - clip.offset) * (
            _SECONDS_PER_FRAME + _SECONDS_PER_PIXEL * clip.width * clip.height
        )
        used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
        hard_limit = resource.getrlimit(resource.RLIMIT_CPU)[1]
        computing = (
            int(used + seconds) if hard_limit == resource.RLIM_INFINITY else min(int(used + seconds), hard_limit)
        )
        resource.setrlimit(resource.RLIMIT_CPU, (computing, computing))
        channel.send({"frames": frames.stop - frames.start})

    try:
        return check_and_unpack(path, folder, limits, limit_computing)
    except (KeyError, TypeError, AttributeError, ValueError, OverflowError, RecursionError) as error:
        raise ImportFormatError(
            f"{path.name} cannot be read ({type(error).__name__}). Create the bundle again."
        ) from error
