"""Chooses the data that `tsr eval` measures on, and writes its figures."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from tsr_engine.cli.common import say
from tsr_engine.errors import InputError, UsageError

if TYPE_CHECKING:
    from tsr_engine.io.gtsdb import Scene
    from tsr_engine.io.gtsrb import CropItem
    from tsr_engine.params import Params
    from tsr_engine.track_table import TrackTable


def held_out_scenes(scenes: list[Scene], models: Path | None) -> list[Scene]:
    """The scenes that training held out for figures.

    Raises:
        InputError: the detector has learned from another number of scenes.
    """
    from tsr_engine.io.models import load_component
    from tsr_engine.training.public.detector_components import split_scenes

    component = load_component("detector", models)
    trained = dict(component.data.get("scenes", {})).get("scenes")
    if trained is not None:
        if trained != len(scenes):
            raise InputError(
                f"--held-out draws the scenes that the training held out of {trained}, but --gtsdb has {len(scenes)}. "
                "Name the scenes of the training, or leave --held-out out."
            )
        say(
            "warning: after its figures were computed, the model was trained again on all scenes, so it does better on "
            "these scenes than on new ones. Its held-out figures are in its manifest."
        )
    return split_scenes(scenes, component.seed or 0)[2]


def select_crops(source: Path, held_out: float | None, seed: int) -> list[CropItem]:
    """The crops of a source, or those of its held-out tracks.

    Raises:
        InputError: there are no crops.
        UsageError: the share is not between 0 and 1.
    """
    from tsr_engine.io.gtsrb import read_items, split_by_track

    items = read_items(source)
    if held_out is None:
        return items
    if not 0 < held_out < 1:
        raise UsageError(f"--held-out expects a share between 0 and 1. Got {held_out:g} instead.")
    chosen = split_by_track([item for item in items if item.track is not None], held_out, seed)[1]
    if not chosen:
        raise InputError(
            f"--held-out needs two tracks of one class or more, in GTSRB's class folders. {source} has none; leave the "
            "option out, or name other folders."
        )
    return chosen


def track_without_files(video: Path, params: Params, models: Path | None, title: str) -> tuple[int, TrackTable]:
    """Track a video without writing files; return the number of frames and the result rows."""
    from tsr_engine.cli.progress import progress_bar, rate_text
    from tsr_engine.evaluation.track_tables import read_results
    from tsr_engine.pipeline import load_components
    from tsr_engine.runs.track_video import RunRequest, track_video

    with tempfile.TemporaryDirectory() as folder, progress_bar(title, "frames") as show:
        csv = Path(folder) / "rows.csv"
        report = track_video(
            RunRequest(video, params, csv=csv),
            load_components(params, models),
            progress=lambda at: show(at.done, at.total, rate_text(at.rate)),
            focus_progress=lambda looked, most: show(looked, most, "to find where the camera points"),
        )
        for warning in report.warnings:
            say(f"warning: {warning}")
        return report.frames, read_results(csv)


def check_output_folder(out: Path | None) -> None:
    """Refuse a folder that is not writable, or plots without their dependencies, before figures are computed."""
    if out is None:
        return
    import tsr_engine.evaluation.plots  # noqa: F401 - reports a missing extra now
    from tsr_engine.io.atomic import refuse_unwritable

    refuse_unwritable(out)


def write_figures(out: Path | None, name: str, content: object) -> None:
    """Write figures as one JSON file, if a folder is given."""
    if out is None:
        return
    from tsr_engine.io.atomic import atomic_text

    with atomic_text(out / name) as stream:
        stream.write(json.dumps(content, indent=1, allow_nan=False) + "\n")
