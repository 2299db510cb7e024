"""Fits the follower's confidence: ``python -m benchmarks.tuning.follow_confidence --clips CLIPS --looming TUNING``.

Follows each sign of the tuning videos from three anchors, once unchanged and once painted over from the middle of its
visible life on. Fits the logistic regression of ``tsr_engine.follow.confidence`` to whether the box lies on the sign.
Prints the weights, and the calibration of the current weights.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from sklearn.linear_model import LogisticRegression

from benchmarks.experiments.follow import TUNED_ON
from benchmarks.following.visible_signs import POSITIONS, Sign, decode, paint_over, signs_of
from benchmarks.videos.approaches import read_approaches
from benchmarks.videos.clips import read_clips
from tsr_engine.follow import FollowerModels
from tsr_engine.follow.camera_motion import CameraMotionEstimator
from tsr_engine.follow.confidence import WEIGHTS, Evidence
from tsr_engine.follow.outward_pass import MAX_HIDDEN_FRAMES, MIN_VISIBLE_SHARE
from tsr_engine.follow.sign_follower import SignFollower, visible_share
from tsr_engine.follow.template import Template
from tsr_engine.follow_video import load_follower
from tsr_engine.geometry.boxes import clip, iou_each
from tsr_engine.pipeline import one_blas_thread
from tsr_engine.records import Picture
from tsr_engine.track_table import TrackTable

Seen = tuple[Evidence, bool]


def main() -> None:
    """Print weights and calibration."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--clips", type=Path, required=True, help="annotated clips; only those of the tuning set are used"
    )
    parser.add_argument("--looming", type=Path, required=True, help="simulated approaches of the tuning set")
    parser.add_argument("--each", type=int, default=2, help="number of approaches of each stress")
    args = parser.parse_args()
    videos = [video for name, video in read_clips(args.clips).items() if name in TUNED_ON]
    videos += read_approaches(args.looming, each=args.each).videos.values()
    parts = load_follower()
    with one_blas_thread():
        seen = [row for path, truth in videos for row in evidence_of(path, truth, parts)]
    for line in report(seen):
        print(line)


def evidence_of(path: Path, truth: TrackTable, parts: FollowerModels) -> Iterator[Seen]:
    """All evidence of one video, and whether each box lies on its sign with an IoU of at least 0.5."""
    pictures = decode(path)
    height, width = pictures[0].shape[:2]
    for sign in signs_of(truth, width, height):
        for shown, rest in ((pictures, sign), paint_over(pictures, sign)):
            if rest.clear:
                for position in POSITIONS:
                    for step in (1, -1):
                        yield from _one_way(shown, rest, rest.anchor(position), step, parts)


def _one_way(pictures: Sequence[Picture], sign: Sign, start: int, step: int, parts: FollowerModels) -> Iterator[Seen]:
    height, width = pictures[0].shape[:2]
    box = sign.life[start]
    look = Template.cut(pictures[start], box, 0.0, True)
    way = SignFollower(pictures[start], box, [look], "forward" if step > 0 else "backward", parts)
    camera = CameraMotionEstimator(pictures[start])
    k = start + step
    while 0 <= k < len(pictures) and way.hidden <= MAX_HIDDEN_FRAMES:
        turn = camera.step(pictures[k])
        found = way.step(pictures[k], turn.shift, turn.repeated)
        if visible_share(found.box, width, height) < MIN_VISIBLE_SHARE:
            return
        if found.evidence is not None and not turn.repeated:
            true = sign.rows.get(k)
            yield found.evidence, true is not None and iou_each(clip(found.box, width, height), true)[0] >= 0.5
        k += step


def report(seen: Sequence[Seen]) -> Iterator[str]:
    """The fitted weights, and the calibration of the current weights, as lines of text."""
    names = list(WEIGHTS)
    terms = np.array([[evidence.terms()[name] for name in names] for evidence, _ in seen])
    on = np.array([good for _, good in seen])
    fitted = LogisticRegression(C=3.0, max_iter=3000, fit_intercept=False).fit(terms, on)
    yield f"{len(on)} boxes, {on.mean():.3f} of them on their sign"
    for name, weight in zip(names, fitted.coef_[0], strict=True):
        yield f"{name}: {weight:.2f} (in force {WEIGHTS[name]:.2f})"
    sure = np.array([evidence.confidence for evidence, _ in seen])
    edges = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 1.0001)
    for low, high in pairwise(edges):
        here = (sure >= low) & (sure < high)
        if here.any():
            span = f"confidence {low:.2f} to {min(high, 1.0):.2f}"
            yield f"{span}: {here.sum()} boxes, {on[here].mean():.3f} of them on their sign"


if __name__ == "__main__":
    main()
