"""Does the loop pay: correct some clips, retrain from them, run on other clips?

The annotations of three clips stand for what a person would have said. A version is refined from them and, beside the
one that it started from, runs on three other clips that nothing was chosen on; with ``--gtsdb`` also on the held-out
scenes. ``--dim`` does the same as a dim, noisy, hard compressed camera would have filmed all clips.

Run: ``TSR_DATA=DIR python benchmarks/retraining.py [--gtsdb DIR] [--models DIR] [--dim] [--seed N]``
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from tsr_engine.detection.acf import AcfModel
from tsr_engine.detection.prior import SpatialPrior
from tsr_engine.evaluation.tracking import evaluate_video, summarise
from tsr_engine.evaluation.tracking_rows import read_clip_truth, read_results
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Track
from tsr_engine.exchange.labels import CLASS_NAMES
from tsr_engine.io.models import SHIPPED, load_component
from tsr_engine.io.video import open_video
from tsr_engine.io.video_writer import VideoWriter
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components
from tsr_engine.records import Picture
from tsr_engine.runs import RunRequest, track_video
from tsr_engine.training.corrections import Sampling, corrected_scenes
from tsr_engine.training.exports import OpenedExport
from tsr_engine.training.heldout import detection_of
from tsr_engine.training.retrain import Recipe, retrain

CORRECTED = ("01_", "SH4_", "SK3_")
HELD_OUT = ("02_", "03_", "SH13_")


def main() -> None:
    """Print figures before and after."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gtsdb", type=Path, help="folder of GTSDB scenes, for figures on its held-out ones")
    parser.add_argument("--models", type=Path, default=SHIPPED, help="the version to start from")
    parser.add_argument("--dim", action="store_true", help="all clips as a dim camera films them")
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    if "TSR_DATA" not in os.environ:
        parser.error("TSR_DATA must name the folder that holds clips/ and clips/gt/.")
    clips = Path(os.environ["TSR_DATA"]) / "clips"
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        videos = {prefix: _video(clips, prefix, work, asked.dim) for prefix in (*CORRECTED, *HELD_OUT)}
        corrections = Dataset(CLASS_NAMES, tuple(videos[prefix] for prefix in CORRECTED))
        opened = OpenedExport(corrections, (), {}, {"name": "annotations of " + ", ".join(CORRECTED)})
        report = retrain(
            [opened], Recipe(seed=asked.seed), asked.models, work / "new", work / "work", _quiet, gtsdb=asked.gtsdb
        )
        held = Dataset(CLASS_NAMES, tuple(videos[prefix] for prefix in HELD_OUT))
        rows = {
            name: _detection(held, models, work / "held") | _tracking(clips, held, models, work)
            for name, models in (("before", asked.models), ("after", work / "new"))
        }
    print("| on the held-out clips | before | after |\n|---|---|---|")
    for key in rows["before"]:
        print(f"| {key} | {rows['before'][key]} | {rows['after'][key]} |")
    print(json.dumps({**report.figures, "used": report.lineage["used"]}, indent=1))


def _quiet(_stage: str, _done: int, _total: int) -> None:
    """Nobody asks."""


def _video(clips: Path, prefix: str, work: Path, dim: bool) -> DatasetVideo:
    """A clip with its annotation as tracks that a person has stated."""
    path = next(clips.glob(f"{prefix}*.mp4"))
    truth = read_clip_truth(clips / "gt" / f"{path.stem}.csv")
    tracks = []
    for sign in np.unique(truth.track_id):
        rows = np.flatnonzero(truth.track_id == sign)
        rows = rows[np.argsort(truth.frame[rows])]
        label = int(np.bincount(truth.class_id[rows] + 1).argmax()) - 1
        n = len(rows)
        tracks.append(
            Track(
                uid=str(sign),
                label=label,
                frames=truth.frame[rows],
                boxes=truth.boxes[rows],
                key=np.ones(n, bool),
                occluded=np.zeros(n, bool),
                score=np.full(n, np.nan),
                ignore=truth.ignore[rows],
                state="truth",
                source="truth",
            )
        )
    if dim:
        path = _dimmed(path, work / path.name)
    with open_video(path) as video:
        frames = len(video.confirm())
        return DatasetVideo(
            path.name, "", video.width, video.height, frames, Fraction(30), None, True, _maker(tracks), path, 0, frames
        )


def _maker(tracks: list[Track]) -> Callable[[], Any]:
    return lambda: iter(tracks)


def _dimmed(source: Path, place: Path) -> Path:
    """The clip with a fifth of the light, noise, soft, compressed hard."""
    with open_video(source) as video:
        writer = VideoWriter(place, video.width, video.height, video.rate)
        for frame in video.frames():
            writer.write(_dim(frame.picture, frame.ordinal))
        writer.close()
    return place


def _dim(picture: Picture, ordinal: int) -> Picture:
    rng = np.random.default_rng(ordinal)
    dark = picture.astype(np.float32) * 0.22 + rng.normal(0, 3.0, picture.shape).astype(np.float32)
    soft = cv2.GaussianBlur(np.clip(dark, 0, 255).astype(np.uint8), (0, 0), 0.9)
    _, code = cv2.imencode(".jpg", soft, [cv2.IMWRITE_JPEG_QUALITY, 45])
    return np.asarray(cv2.imdecode(code, cv2.IMREAD_COLOR), dtype=np.uint8)


def _detection(held: Dataset, models: Path, work: Path) -> dict[str, Any]:
    """AP of single frames, every second one or so."""
    scenes = corrected_scenes(held, work, Sampling(signs=60, background=60))
    detector, prior = load_component("detector", models), load_component("prior", models)
    found = detection_of(
        AcfModel.from_arrays(detector.arrays, detector.params),
        SpatialPrior(prior.arrays["table"].astype(np.float32), float(prior.params["lambda"])),
        scenes,
        _quiet,
    )
    return {
        "AP at IoU 0.5": found["ap50"],
        "AP at IoU 0.75": found["ap75"],
        "recall at 0.1 false a frame": found["recall_at_0.1"],
        "mean Eq. 7 of detections": found["mean_eq7"],
        "boxes, frames": f"{found['boxes']}, {found['pictures']}",
    }


def _tracking(clips: Path, held: Dataset, models: Path, work: Path) -> dict[str, Any]:
    """Figures of whole runs."""
    params = Params.preset("default")
    reports = []
    for video in held.videos:
        assert video.path is not None
        rows = work / "rows.csv"
        track_video(RunRequest(video.path, params, csv=rows), load_components(params, models))
        truth = read_clip_truth(clips / "gt" / f"{video.path.stem}.csv")
        reports.append(evaluate_video(video.name, truth, read_results(rows), video.frames))
    s = summarise(reports)
    return {
        "coverage": round(s.coverage or 0, 4),
        "mean Eq. 7 of tracks": round(s.mean_error or 0, 4),
        "false tracks": s.false_tracks,
        "signs found": f"{s.signs_detected} of {s.signs}",
        "signs read right": f"{s.signs_classified} of {s.signs}",
    }


if __name__ == "__main__":
    main()
