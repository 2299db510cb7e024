"""Tables that tracking is evaluated on: ground truth and the result rows of ``tsr track --csv``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import InputError
from tsr_engine.evaluation.strict_rows import BadRow, read_mot_table, read_result_table, read_truth_table
from tsr_engine.geometry.boxes import clip
from tsr_engine.records import FloatArray

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class GroundTruth:
    """Annotated boxes of one video, one row a sign and frame.

    Attributes:
        frame: shape (n,), 0-based.
        track_id: shape (n,), the physical sign.
        boxes: shape (n, 4).
        class_id: shape (n,); -1 is a sign of no known class.
        visibility: shape (n,), visible share in [0, 1].
        ignore: shape (n,); such a row counts neither as a miss nor as false.
    """

    frame: IntArray
    track_id: IntArray
    boxes: FloatArray
    class_id: IntArray
    visibility: FloatArray
    ignore: BoolArray


@dataclass(frozen=True, slots=True)
class Results:
    """Tracked boxes of one video, columns as in the CSV of ``tsr track``.

    Attributes:
        frame: shape (n,), 0-based.
        track_id: shape (n,).
        boxes: shape (n, 4).
        class_id: shape (n,).
        score: shape (n,).
        source: n times ``detected``, ``predicted`` or ``relocalised``.
    """

    frame: IntArray
    track_id: IntArray
    boxes: FloatArray
    class_id: IntArray
    score: FloatArray
    source: tuple[str, ...]

    @classmethod
    def of(cls, rows: Iterable[tuple[int, int, FloatArray, int, float, str]]) -> Results:
        """Results of rows ``frame, track_id, box, class_id, score, source``."""
        table = list(rows)
        boxes = np.array([r[2] for r in table], dtype=np.float64).reshape(-1, 4)
        return cls(
            np.array([r[0] for r in table], dtype=np.int64),
            np.array([r[1] for r in table], dtype=np.int64),
            boxes,
            np.array([r[3] for r in table], dtype=np.int64),
            np.array([r[4] for r in table], dtype=np.float64),
            tuple(r[5] for r in table),
        )


def in_view(truth: GroundTruth, results: Results, width: int, height: int) -> tuple[GroundTruth, Results]:
    """Both, cut to the picture: annotators of real drives stop at its edge, exact truth and a tracker's boxes do not.

    What lies wholly beyond the picture keeps its row, without area.

    Args:
        truth: annotated rows.
        results: tracked rows.
        width: of the pictures, px.
        height: of the pictures, px.
    """
    return (
        replace(truth, boxes=clip(truth.boxes, width, height)),
        replace(results, boxes=clip(results.boxes, width, height)),
    )


def thinned(truth: GroundTruth, step: int) -> GroundTruth:
    """The rows of every ``step``-th frame, from the first on, with the frames counted anew."""
    here = truth.frame % step == 0
    rows = {column.name: getattr(truth, column.name)[here] for column in fields(truth)}
    return GroundTruth(**rows | {"frame": rows["frame"] // step})


def read_clip_truth(path: Path) -> GroundTruth:
    """Truth from a CSV with the columns ``frame,track_id,x1,y1,x2,y2,class_id,visibility,ignore``.

    Raises:
        InputError: no such file, missing columns, or a row that breaks a rule of :mod:`~.strict_rows`.
    """
    with _named(path):
        table = read_truth_table(_content(path))
    return GroundTruth(
        table[:, 0].astype(np.int64),
        table[:, 1].astype(np.int64),
        table[:, 2:6].copy(),
        table[:, 6].astype(np.int64),
        table[:, 7].copy(),
        table[:, 8] != 0,
    )


def read_mot_truth(path: Path) -> GroundTruth:
    """Truth from MOTChallenge rows ``frame,id,left,top,width,height,flag,class_id,visibility``, frames from 1.

    A flag of 0 marks a row to ignore.

    Raises:
        InputError: no such file, or a row that breaks a rule of :mod:`~.strict_rows`.
    """
    with _named(path):
        table = read_mot_table(_content(path))
    boxes = np.concatenate([table[:, 2:4], table[:, 2:4] + table[:, 4:6]], axis=1)
    return GroundTruth(
        table[:, 0].astype(np.int64) - 1,
        table[:, 1].astype(np.int64),
        boxes,
        table[:, 7].astype(np.int64),
        table[:, 8].copy(),
        table[:, 6] == 0,
    )


def read_results(path: Path) -> Results:
    """Results from the CSV of ``tsr track`` or ``tsr replay``.

    Raises:
        InputError: no such file, missing columns, or a row that breaks a rule of :mod:`~.strict_rows`.
    """
    with _named(path):
        table, source = read_result_table(_content(path))
    return Results(
        table[:, 0].astype(np.int64),
        table[:, 1].astype(np.int64),
        table[:, 2:6].copy(),
        table[:, 6].astype(np.int64),
        table[:, 7].copy(),
        source,
    )


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"Expected a readable text table at {path}, got: {error.strerror}. Check the path.") from None


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """A broken rule as a sentence about a file."""
    try:
        yield
    except BadRow as error:
        raise InputError(f"{path}, line {error.line}: {error.rule}. Correct the table.") from None
