"""The exact ground truth of a drive: the box of each sign's face in each frame, and its visible share."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from tsr_engine.json_shapes import JsonMapping

MIN_FACE_PX = 12.0
"""Shorter side of a face, pixels, below which it is to be ignored."""

MIN_VISIBILITY = 0.35
"""Visible share of a face below which it cannot be read and is to be ignored."""

HEADER = ("frame", "track_id", "x1", "y1", "x2", "y2", "class_id", "visibility", "ignore")


class Row(NamedTuple):
    """One sign in one frame.

    Attributes:
        frame: Frame number, from 0.
        track_id: The sign's number, from 1; the same throughout the drive.
        x1: Left of the tight box of the face, pixel edges, cut to the picture.
        y1: Top.
        x2: Right.
        y2: Bottom.
        class_id: GTSRB class.
        visibility: Visible share of the projected face: inside the picture and not covered by nearer objects.
        ignore: 1 if the face is smaller than `MIN_FACE_PX` or its visible share below `MIN_VISIBILITY`.
    """

    frame: int
    track_id: int
    x1: float
    y1: float
    x2: float
    y2: float
    class_id: int
    visibility: float
    ignore: int


def make_row(
    frame: int,
    track_id: int,
    bounds: tuple[float, float, float, float],
    size: tuple[int, int],
    class_id: int,
    visibility: float,
) -> Row | None:
    """Make the row of a face, cut to the picture; None: the face lies outside.

    Args:
        frame: Frame number.
        track_id: The sign.
        bounds: x1, y1, x2, y2 of the whole face, inside the picture or not.
        size: Width and height of the picture.
        class_id: GTSRB class.
        visibility: Visible share.
    """
    x1, y1, x2, y2 = bounds
    small = min(x2 - x1, y2 - y1) < MIN_FACE_PX
    x1, y1, x2, y2 = max(x1, 0.0), max(y1, 0.0), min(x2, float(size[0])), min(y2, float(size[1]))
    if x2 - x1 <= 0.5 or y2 - y1 <= 0.5:
        return None
    ignore = int(small or visibility < MIN_VISIBILITY)
    return Row(
        frame, track_id, round(x1, 2), round(y1, 2), round(x2, 2), round(y2, 2), class_id, round(visibility, 3), ignore
    )


def write_csv(path: Path, rows: Iterable[Row]) -> None:
    """Write rows in the layout of `HEADER`."""
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(HEADER)
        for r in rows:
            out.writerow(
                [r.frame, r.track_id, *(f"{v:.2f}" for v in r[2:6]), r.class_id, f"{r.visibility:.3f}", r.ignore]
            )


def write_json(path: Path, facts: JsonMapping) -> None:
    """Write the facts about a drive."""
    path.write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")
