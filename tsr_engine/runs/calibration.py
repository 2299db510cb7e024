"""Estimates the camera of a drive from its video."""

from __future__ import annotations

from collections.abc import Callable

from tsr_engine.errors import UsageError, VideoError
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video import VideoLimits, open_video
from tsr_engine.params import Params
from tsr_engine.records import FloatArray
from tsr_engine.tracking.camera_shift import CameraShift
from tsr_engine.tracking.focus import Focus, find_focus

__all__ = ["ENOUGH", "MOST", "PORTION", "aimed", "calibrate"]

PORTION = 250
"""So many frames are looked at before the answer is weighed."""
ENOUGH = 0.01
"""A standard error, share of the height, at which no further portion is looked at."""
MOST = 3000
"""... and so many frames at most: a car that stands for two minutes may stand for longer."""


def calibrate(
    path: VideoSource,
    start: int = 0,
    stop: int | None = None,
    *,
    x: float = 0.5,
    scale: int = 4,
    limits: VideoLimits | None = None,
    progress: Callable[[int, int | None], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Focus | None:
    """The height of the focus of expansion of the camera of a drive.

    Args:
        path: the video.
        start: first frame.
        stop: end, exclusive; unset: as soon as a portion is certain enough, ``MOST`` frames after the first at last.
        x: of the focus, share of the width.
        scale: flow is looked for in pictures made smaller by this factor.
        limits: what the video may demand; unset: ``VideoLimits()``.
        progress: called after each frame with the number of frames done and the most there are to do, if known.
        cancelled: asked before each frame; true ends the search with what is known by then.

    Returns:
        None if the car drives too little for an answer.

    Raises:
        VideoError: the video cannot be opened or decoded.
        UsageError: the range lies beyond the end.
    """
    camera, size = CameraShift(scale), (0, 0)
    flows: list[tuple[FloatArray, FloatArray]] = []
    end = start + MOST if stop is None else stop
    with open_video(path, limits=limits) as video:
        total = None if video.expected is None else max(0, min(end, video.expected) - start)
        for done, frame in enumerate(video.frames(start, end, ahead=2), 1):
            if cancelled is not None and cancelled():
                break
            if (found := camera.flow(frame.picture)) is not None:
                points, flow, size = found
                flows.append((points, flow))
            if progress is not None:
                progress(done, total)
            if stop is None and done % PORTION == 0:
                found_by_now = find_focus(flows, *size, x)
                if found_by_now is not None and found_by_now.error <= ENOUGH:
                    return found_by_now
    return find_focus(flows, *size, x)


def aimed(
    params: Params,
    path: VideoSource,
    cancelled: Callable[[], bool] | None = None,
    *,
    limits: VideoLimits | None = None,
    progress: Callable[[int, int | None], None] | None = None,
) -> tuple[Params, Focus | None]:
    """Parameters of a run over a drive whose camera is estimated from the drive, unless they name its focus themselves.

    The estimate uses the beginning of the drive, whichever frames are tracked, so that every run has the same camera.

    Args:
        params: of the run.
        path: the video.
        cancelled: asked before each frame; true ends the search.
        limits: what the video may demand; unset: ``VideoLimits()``.
        progress: called after each frame that is looked at, as by :func:`calibrate`.

    Returns:
        The parameters, with ``coast_foe_y`` set if it was asked for and could be estimated, and the estimate.
    """
    tracking = params.tracking
    if tracking.coast_foe_y is not None or tracking.motion != "looming":
        return params, None
    try:
        focus = calibrate(
            path,
            x=tracking.foe_x,
            scale=tracking.shift_scale,
            limits=limits,
            progress=progress,
            cancelled=cancelled,
        )
    except (VideoError, UsageError):  # the run itself comes to that frame, and says so
        return params, None
    return (params, None) if focus is None else (params.with_settings([("coast_foe_y", round(focus.y, 3))]), focus)
