"""Estimates the camera of a drive from its video."""

from __future__ import annotations

from collections.abc import Callable

from tsr_engine.errors import UsageError, VideoError
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video import VideoLimits, open_video
from tsr_engine.params import Params
from tsr_engine.records import FloatArray
from tsr_engine.tracking.camera_shift import CameraShift
from tsr_engine.tracking.focus_of_expansion import Focus, find_focus

ESTIMATE_EVERY_FRAMES = 250
"""Number of frames between two estimates."""
MAX_STANDARD_ERROR = 0.01
"""Standard error at which the estimation stops, share of the height."""
MAX_FRAMES = 3000
"""Largest number of frames. A car that stands still for two minutes may stand for much longer."""


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
    """Estimate the height of the focus of expansion of a drive's camera.

    Args:
        path: the video.
        start: first frame.
        stop: end, exclusive; unset: when the estimate is exact enough (``MAX_STANDARD_ERROR``), at most
            ``MAX_FRAMES`` later.
        x: horizontal position of the focus, share of the width.
        scale: factor by which pictures are reduced to measure the flow.
        limits: limits on the video; unset: ``VideoLimits()``.
        progress: called after each frame with the number of frames done, and the largest number to do if known.
        cancelled: called before each frame; if it returns true, the estimation ends with the frames up to then.

    Returns:
        The focus; None if the car drives too little for an estimate.

    Raises:
        VideoError: the video cannot be opened or decoded.
        UsageError: the range lies beyond the end.
    """
    camera, size = CameraShift(scale), (0, 0)
    flows: list[tuple[FloatArray, FloatArray]] = []
    end = start + MAX_FRAMES if stop is None else stop
    with open_video(path, limits=limits) as video:
        total = None if video.expected is None else max(0, min(end, video.expected) - start)
        for done, frame in enumerate(video.frames(start, end, ahead=2), 1):
            if cancelled is not None and cancelled():
                break
            if (measured := camera.flow(frame.picture)) is not None:
                points, flow, size = measured
                flows.append((points, flow))
            if progress is not None:
                progress(done, total)
            if stop is None and done % ESTIMATE_EVERY_FRAMES == 0:
                estimate = find_focus(flows, *size, x)
                if estimate is not None and estimate.error <= MAX_STANDARD_ERROR:
                    return estimate
    return find_focus(flows, *size, x)


def with_focus(
    params: Params,
    path: VideoSource,
    cancelled: Callable[[], bool] | None = None,
    *,
    limits: VideoLimits | None = None,
    progress: Callable[[int, int | None], None] | None = None,
) -> tuple[Params, Focus | None]:
    """Parameters of a run with the camera's focus, which is estimated from the drive unless they set it.

    The estimate always uses the beginning of the drive, so that all runs of a drive have the same camera.

    Args:
        params: parameters of the run.
        path: the video.
        cancelled: called before each frame; true ends the estimation.
        limits: limits on the video; unset: ``VideoLimits()``.
        progress: called after each frame, as by :func:`calibrate`.

    Returns:
        The parameters, with ``coast_foe_y`` set if the motion model needs it and the estimate succeeds; and the
        estimate.
    """
    tracking = params.tracking
    if tracking.coast_foe_y is not None or tracking.motion != "looming":
        return params, None
    try:
        focus = calibrate(
            path, x=tracking.foe_x, scale=tracking.shift_scale, limits=limits, progress=progress, cancelled=cancelled
        )
    except (VideoError, UsageError):  # the run reports it when it reaches that frame
        return params, None
    return (params, None) if focus is None else (params.with_settings([("coast_foe_y", round(focus.y, 3))]), focus)
