"""A tracked toy drive, bundles of it, and their expectations."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from tests import pipeline_toys as toys
from tsr_engine.bundle import BundleReport, BundleRequest, Expectation, make_bundle
from tsr_engine.runs.track_video import RunRequest, track_video


class Drive(NamedTuple):
    """A video and its run."""

    toys: Any
    video: Path
    run: Path

    def bundle(self, out: Path, first: int = 46, stop: int = 70, **values: Any) -> BundleReport:
        given = {"recording": False, "note": "wrong", **values}
        return make_bundle(BundleRequest(self.run, self.video, out, first, stop, **given))


def make_drive(folder: Path) -> Drive:
    """Track 75 frames with two signs: one in frames 4 to 33, one from frame 44 on."""
    video = toys.write_drive(folder / "drive.mp4", 75)
    track_video(RunRequest(video, toys.PARAMS, folder / "run"), toys.components(toys.PARAMS))
    return Drive(toys, video, folder / "run")


def expectation(**content: Any) -> Expectation:
    """An expectation from plain values."""
    return Expectation.model_validate(content)
