"""A tracked toy drive, bundles of it, and their expectations."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from tests import toy_pipeline
from tsr_engine.bundle import BundleReport, BundleRequest, Expectation, make_bundle
from tsr_engine.runs.track_video import RunRequest, track_video


class TrackedDrive(NamedTuple):
    """A video and its run."""

    video: Path
    run: Path

    def bundle(self, out: Path, first: int = 46, stop: int = 70, **values: Any) -> BundleReport:
        given = {"recording": False, "note": "wrong", **values}
        return make_bundle(BundleRequest(self.run, self.video, out, first, stop, **given))


def make_tracked_drive(folder: Path) -> TrackedDrive:
    """Track 75 frames with two signs: one in frames 4 to 33, one from frame 44 on."""
    video = toy_pipeline.write_drive(folder / "drive.mp4", 75)
    track_video(RunRequest(video, toy_pipeline.PARAMS, folder / "run"), toy_pipeline.components())
    return TrackedDrive(video, folder / "run")


def make_expectation(**content: Any) -> Expectation:
    """An expectation from plain values."""
    return Expectation.model_validate(content)
