"""What a drive tells of the camera that filmed it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tsr_engine.errors import InputError
from tsr_engine.io.video import open_video
from tsr_engine.tracking.camera_shift import CameraShift
from tsr_engine.tracking.focus import Focus, find_focus

__all__ = ["FRAMES", "calibrate"]

FRAMES = 1500
"""So many frames are looked at where nothing else is asked for: a minute tells more than enough."""


def calibrate(
    path: Path, start: int = 0, stop: int | None = None, progress: Callable[[int, int | None], None] | None = None
) -> Focus:
    """The height of the focus of expansion of the camera of a drive.

    Args:
        path: the video.
        start: first frame.
        stop: end, exclusive; unset: ``FRAMES`` after the first.
        progress: called after each frame with the number of frames done and the total, if known.

    Raises:
        VideoError: the video cannot be opened or decoded.
        UsageError: the range lies beyond the end.
        InputError: the car drives too little for an answer.
    """
    end = start + FRAMES if stop is None else stop
    camera, flows, size = CameraShift(), [], (0, 0)
    with open_video(path) as video:
        total = None if video.expected is None else max(0, min(end, video.expected) - start)
        for done, frame in enumerate(video.frames(start, end, ahead=2), 1):
            if (found := camera.flow(frame.picture)) is not None:
                points, flow, size = found
                flows.append((points, flow))
            if progress is not None:
                progress(done, total)
    focus = find_focus(flows, *size)
    if focus is None:
        raise InputError(
            f"The car in {path} comes too little nearer to what it sees to tell where its camera looks. "
            "Choose --frames in which it drives on."
        )
    return focus
