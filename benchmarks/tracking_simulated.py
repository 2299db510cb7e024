"""Tracking on simulated detections: the three motion models on the same noisy boxes.

Ground-truth boxes of clips become detections: every edge gets Gaussian noise of a share of the width, a detection is
missed with probability 1 - p, hidden signs are never detected, and false detections are sprinkled in. The camera
shift is measured on the pictures. Prints one row for each data set, p and motion model; "detections" are the raw boxes
under perfect identities: what no tracker that only returns matched boxes can surpass in coverage.

    python benchmarks/tracking_simulated.py --clips DIR --names 02_71ec1e 03_c0da85 SH13_9f8bd8
    python benchmarks/tracking_simulated.py --looming DIR
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np

from tsr_engine.evaluation.tracking import TrackingSummary, VideoReport, evaluate_video, summarise
from tsr_engine.evaluation.tracking_rows import read_clip_truth, read_mot_truth, thinned
from tsr_engine.geometry.boxes import iou
from tsr_engine.params.tracking import TrackingParams
from tsr_engine.records import Detections, FloatArray
from tsr_engine.track_table import TrackTable
from tsr_engine.tracking.camera_shift import CameraShift
from tsr_engine.tracking.tracker import Tracker


@dataclass(frozen=True)
class Video:
    """Truth and camera motion of one clip."""

    name: str
    group: str
    truth: TrackTable
    frames: int
    width: int
    height: int
    shifts: list[tuple[float, float]]


def load(path: Path, name: str, group: str, truth: TrackTable, step: int) -> Video:
    """Decodes a clip once to measure its shifts; keeps every ``step``-th frame."""
    estimator = CameraShift()
    shifts = []
    width = height = 0
    with av.open(str(path)) as container:
        for ordinal, frame in enumerate(container.decode(video=0)):
            if ordinal % step:
                continue
            picture = frame.to_ndarray(format="bgr24")
            height, width = picture.shape[:2]
            shifts.append(estimator.step(picture))
    return Video(name, group, thinned(truth, step), len(shifts), width, height, shifts)


def simulate(
    video: Video, p_det: float, noise: float, false_rate: float, rng: np.random.Generator
) -> dict[int, Detections]:
    """Detections of every frame from the truth; signs under 16 px or less than 60 % visible are not seen."""
    truth, frames = video.truth, {}
    wide = truth.boxes[:, 2] - truth.boxes[:, 0] >= 16
    for frame in range(video.frames):
        boxes, scores = [], []
        for row in np.flatnonzero((truth.frame == frame) & ~truth.ignore & wide & (truth.visibility >= 0.6)):
            box = truth.boxes[row]
            sizes = np.array([box[2] - box[0], box[3] - box[1]] * 2)
            noisy = box + rng.normal(0, noise, 4) * sizes
            score = rng.normal(2.0, 1.0)
            if rng.random() < p_det and score > -2 and (noisy[2:] - noisy[:2] > 4).all():
                boxes.append(noisy)
                scores.append(score)
        for _ in range(rng.poisson(false_rate)):
            side = rng.uniform(16, 60)
            corner = rng.uniform([0, 0], [video.width - side, video.height - side])
            boxes.append(np.concatenate([corner, corner + side]))
            scores.append(rng.normal(0.5, 1.0))
        s = np.array(scores, dtype=np.float64)
        table: FloatArray = np.array(boxes, dtype=np.float64).reshape(-1, 4)
        frames[frame] = Detections(table, s, np.full(len(s), 0.5), s).select(np.argsort(-s, kind="stable"))
    return frames


def track(video: Video, detections: dict[int, Detections], params: TrackingParams) -> TrackTable:
    """Kalman filter alone; rows of confirmed tracks from their first frame on."""
    tracker = Tracker(params, video.width, video.height)
    rows, confirmed = [], set()
    for frame in range(video.frames):
        for t in tracker.step(frame, detections[frame], 1.0, video.shifts[frame]).tracks:
            rows.append((frame, t.track_id, t.box, 0, t.score, t.source))
            if t.state == "confirmed":
                confirmed.add(t.track_id)
    return TrackTable.of_rows(row for row in rows if row[1] in confirmed)


def raw(video: Video, detections: dict[int, Detections]) -> TrackTable:
    """The detections themselves, each with the id of the sign that it overlaps most; false ones are left out."""
    rows = []
    for frame, found in detections.items():
        here = np.flatnonzero((video.truth.frame == frame) & ~video.truth.ignore)
        if len(here) and len(found):
            overlap = iou(found.boxes, video.truth.boxes[here])
            for i in np.flatnonzero(overlap.max(axis=1) > 0):
                sign = int(video.truth.track[here[overlap[i].argmax()]])
                rows.append((frame, sign, found.boxes[i], 0, float(found.scores[i]), "detected"))
    return TrackTable.of_rows(rows)


def evaluate(
    videos: list[Video], params: TrackingParams | None, p_det: float, args: argparse.Namespace
) -> tuple[TrackingSummary, list[VideoReport]]:
    """All videos, each with ``args.repeats`` independent draws of detections; raw detections without ``params``."""
    reports = []
    for k, video in enumerate(videos):
        for repeat in range(args.repeats):
            rng = np.random.default_rng([args.seed, k, repeat])
            detections = simulate(video, p_det, args.noise, args.false_rate, rng)
            rows = raw(video, detections) if params is None else track(video, detections, params)
            size = (video.width, video.height)
            reports.append(evaluate_video(video.name, video.truth, rows, video.frames, size=size))
    return summarise(reports), reports


def load_all(args: argparse.Namespace) -> list[Video]:
    """The clips that the arguments name."""
    videos = []
    for name in args.names or []:
        truth = read_clip_truth(args.clips / "gt" / f"{name}.csv")
        videos.append(load(args.clips / f"{name}.mp4", name, "clips", truth, args.step))
    if args.looming:
        for clip in json.loads((args.looming / "clips.json").read_text())["clips"]:
            folder = args.looming / clip["clip"]
            truth = read_mot_truth(folder / "gt.txt")
            videos.append(load(folder / "video.mp4", clip["clip"], clip["stress"], truth, args.step))
    return videos


def parse() -> argparse.Namespace:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--clips", type=Path, help="folder of clips with gt/")
    parser.add_argument("--names", nargs="*", help="clips in it")
    parser.add_argument("--looming", type=Path, help="folder made by looming.py")
    parser.add_argument("--noise", type=float, default=0.10, help="std of an edge, share of the size")
    parser.add_argument("--false-rate", type=float, default=0.05, help="false detections a frame")
    parser.add_argument("--step", type=int, default=1, help="take every n-th frame (3: 30 fps become 10)")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--seed", type=int, default=7)
    return parser.parse_args()


def main() -> None:
    """Prints the table."""
    args = parse()
    videos = load_all(args)
    header = ("p_det", "data", "motion", "coverage", "ids/sign", "found", "false", "Eq. 7", "Eq. 7 followed")
    print("".join(f"{name:>18}" for name in header))
    groups = sorted({video.group for video in videos})
    for p_det in (0.8, 0.6):
        for group in [*groups, "all"] if len(groups) > 1 else groups:
            chosen = [video for video in videos if group in (video.group, "all")]
            for motion in ("detections", "paper", "constant_velocity", "looming"):
                known = motion != "detections"
                params = TrackingParams(motion=motion, use_camera_shift=motion != "paper") if known else None
                s = evaluate(chosen, params, p_det, args)[0]
                cells = [f"{p_det}", group, motion]
                cells += [f"{s.coverage:.3f}", f"{s.ids_per_sign:.3f}", f"{s.signs_detected}/{s.signs}"]
                cells += [f"{s.false_tracks}", f"{s.mean_error:.4f}", f"{s.mean_error_followed:.4f}"]
                print("".join(f"{cell:>18}" for cell in cells), flush=True)


if __name__ == "__main__":
    main()
