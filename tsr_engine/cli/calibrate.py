"""`tsr calibrate`: where the camera of a drive looks."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from tsr_engine.cli.common import JsonOption, existing, frame_range, print_json
from tsr_engine.errors import InputError


def calibrate(
    video: Annotated[Path, typer.Argument(help="Video file of a drive.")],
    frames: Annotated[
        str | None,
        typer.Option("--frames", metavar="A:B", help="Use frames A to B-1, counted from 0; unset: as many as needed."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Estimate from a drive how high the camera's focus of expansion lies.

    Signs move away from this point as they come nearer; with a wrong one, a track without detections drifts off its
    sign. `tsr track` estimates it in the same way from the first frames of each drive. If you know the value of a
    camera, set it for all of its drives.

    \b
    Examples:
      tsr calibrate drive.mp4
      tsr track drive.mp4 --set coast_foe_y=0.65
    """
    start, stop = frame_range(frames)
    from tsr_engine.cli.progress import progress_bar
    from tsr_engine.runs import calibration

    path = existing(video, "video")
    with progress_bar("calibrating", "frames") as show:
        focus = calibration.calibrate(path, start, stop, progress=lambda done, total: show(done, total, ""))
    if focus is None:
        raise InputError(
            f"The car in {path} moves forward too little to estimate where its camera points. "
            "Choose --frames in which it drives."
        )
    if as_json:
        print_json({"coast_foe_y": focus.y, "error": focus.error, "frames": focus.frames, "approach": focus.approach})
        return
    # Without its "./" the name may look like an option.
    name = f"./{video}" if str(video).startswith("-") else str(video)
    typer.echo(
        f"{video.name}: the focus of expansion lies at {focus.y:.3f} of the height (standard error {focus.error:.3f}, "
        f"from {focus.frames} frames).\ntsr track {shlex.quote(name)} --set coast_foe_y={focus.y:.3f}"
    )
