"""Places where results got worse, the worst first: signs lost, misread or covered less, and new false tracks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from app.check.reviewed import ReviewedDrive
from tsr_engine.evaluation.tracking import SignReport, VideoReport
from tsr_engine.geometry.boxes import iou
from tsr_engine.track_table import TrackTable

Kind = Literal["lost", "misread", "false", "less"]
_ORDER: Final[tuple[Kind, ...]] = ("lost", "misread", "false", "less")
_MIN_LOST_SHARE: Final = 0.1
"""Smallest share of its frames that a sign must lose to be listed."""


@dataclass(frozen=True, slots=True)
class Regression:
    """One place that got worse.

    Attributes:
        drive: index of the drive.
        kind: ``lost``, ``misread``, ``false`` or ``less`` (covered in fewer frames).
        what: track of the ground truth; for ``false``, of the results.
        first, last: frames of the track.
        frame: frame in which its box is widest.
        box: the box in that frame, px.
        weight: severity within its kind; higher is worse.
        class_id, got: label in the ground truth, and in the results; None: there is none.
    """

    drive: int
    kind: Kind
    what: int
    first: int
    last: int
    frame: int
    box: tuple[float, float, float, float]
    weight: float
    class_id: int | None = None
    got: int | None = None


def find_regressions(
    drives: Sequence[ReviewedDrive],
    before: Sequence[VideoReport],
    after: Sequence[VideoReport],
    results: Sequence[TrackTable],
) -> list[Regression]:
    """Find the regressions.

    Args:
        drives: reviewed drives.
        before: reports on the runs' own results, one per drive.
        after: reports on the new results, one per drive.
        results: the new results, one per drive.

    Returns:
        The places, by kind and then worst first.
    """
    found: list[Regression] = []
    for index, (drive, old, new, rows) in enumerate(zip(drives, before, after, results, strict=True)):
        old_signs = {sign.track_id: sign for sign in old.signs}
        for sign in new.signs:
            regression = _sign(index, drive, old_signs[sign.track_id], sign)
            if regression is not None:
                found.append(regression)
        found += [_false(index, rows, track) for track in new.false_tracks if _is_new(rows, track, drive, old)]
    return sorted(found, key=lambda each: (_ORDER.index(each.kind), -each.weight, each.drive, each.what))


def _sign(drive_index: int, drive: ReviewedDrive, old: SignReport, new: SignReport) -> Regression | None:
    truth = drive.truth
    rows = np.flatnonzero((truth.track == new.track_id) & ~truth.ignore)
    boxes = truth.boxes[rows]
    largest = int(np.argmax(boxes[:, 2] - boxes[:, 0]))
    lost = (old.covered - new.covered) / max(1, new.frames)
    kind: Kind
    if old.ids and not new.ids:
        kind, weight = "lost", float(new.frames)
    elif new.ids and new.class_id >= 0 and old.predicted_class == old.class_id != new.predicted_class:
        kind, weight = "misread", float(boxes[largest, 2] - boxes[largest, 0])
    elif lost >= _MIN_LOST_SHARE:
        kind, weight = "less", lost
    else:
        return None
    frames = truth.frame[rows]
    x1, y1, x2, y2 = boxes[largest].tolist()
    return Regression(
        drive_index, kind, new.track_id, int(frames.min()), int(frames.max()), int(frames[largest]), (x1, y1, x2, y2),
        weight, new.class_id if new.class_id >= 0 else None, new.predicted_class,
    )  # fmt: skip


def _false(drive_index: int, rows: TrackTable, track: int) -> Regression:
    track_rows = np.flatnonzero(rows.track == track)
    boxes = rows.boxes[track_rows]
    largest = int(np.argmax(boxes[:, 2] - boxes[:, 0]))
    x1, y1, x2, y2 = boxes[largest].tolist()
    frames, got = rows.frame[track_rows], int(rows.class_id[track_rows[-1]])
    return Regression(
        drive_index, "false", track, int(frames.min()), int(frames.max()), int(frames[largest]), (x1, y1, x2, y2),
        float(len(track_rows)), None, got if got >= 0 else None,
    )  # fmt: skip


def _is_new(rows: TrackTable, track: int, drive: ReviewedDrive, old: VideoReport) -> bool:
    """Whether the run did not already have this false track."""
    track_rows = np.flatnonzero(rows.track == track)
    known = np.flatnonzero(np.isin(drive.results.track, old.false_tracks))
    for row in track_rows:
        same = known[drive.results.frame[known] == rows.frame[row]]
        if len(same) and bool((iou(rows.boxes[row], drive.results.boxes[same]) >= 0.5).any()):
            return False
    return True
