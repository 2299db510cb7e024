"""Tables that tracking is evaluated on: ground truth and the result rows of ``tsr track --csv``."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import InputError
from tsr_engine.geometry.boxes import clip
from tsr_engine.records import FloatArray

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_TRUTH_COLUMNS = ("frame", "track_id", "x1", "y1", "x2", "y2", "class_id", "visibility", "ignore")
_RESULT_COLUMNS = ("frame", "track_id", "x1", "y1", "x2", "y2", "class_id", "score", "source")


@dataclass(frozen=True, slots=True)
class Truth:
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


def in_view(truth: Truth, results: Results, width: int, height: int) -> tuple[Truth, Results]:
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


def thinned(truth: Truth, step: int) -> Truth:
    """The rows of every ``step``-th frame, from the first on, with the frames counted anew."""
    here = truth.frame % step == 0
    rows = {column.name: getattr(truth, column.name)[here] for column in fields(truth)}
    return Truth(**rows | {"frame": rows["frame"] // step})


def read_clip_truth(path: Path) -> Truth:
    """Truth from a CSV with the columns ``frame,track_id,x1,y1,x2,y2,class_id,visibility,ignore``.

    Raises:
        InputError: no such file, missing columns, or a value that is not a number.
    """
    rows = _read_csv(path, _TRUTH_COLUMNS)
    table = _numbers(path, rows, _TRUTH_COLUMNS)
    return Truth(
        table[:, 0].astype(np.int64),
        table[:, 1].astype(np.int64),
        table[:, 2:6].copy(),
        table[:, 6].astype(np.int64),
        table[:, 7].copy(),
        table[:, 8] != 0,
    )


def read_mot_truth(path: Path) -> Truth:
    """Truth from MOTChallenge rows ``frame,id,left,top,width,height,flag,class_id,visibility``, frames from 1.

    A flag of 0 marks a row to ignore.

    Raises:
        InputError: no such file, or a row without nine numbers.
    """
    names = ("frame", "id", "left", "top", "width", "height", "flag", "class_id", "visibility")
    lines = [line for line in _text(path).splitlines() if line.strip()]
    rows = [dict(zip(names, line.split(","), strict=False)) for line in lines]
    table = _numbers(path, rows, names)
    boxes = np.concatenate([table[:, 2:4], table[:, 2:4] + table[:, 4:6]], axis=1)
    return Truth(
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
        InputError: no such file, missing columns, or a value that is not a number.
    """
    rows = _read_csv(path, _RESULT_COLUMNS)
    table = _numbers(path, rows, _RESULT_COLUMNS[:-1])
    return Results(
        table[:, 0].astype(np.int64),
        table[:, 1].astype(np.int64),
        table[:, 2:6].copy(),
        table[:, 6].astype(np.int64),
        table[:, 7].copy(),
        tuple(row["source"] for row in rows),
    )


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        got = error.strerror if isinstance(error, OSError) else "something that is no text"
        raise InputError(f"Expected a readable text table at {path}, got: {got}. Check the path.") from None


def _read_csv(path: Path, columns: Sequence[str]) -> list[dict[str, str]]:
    reader = csv.DictReader(_text(path).splitlines())
    missing = [name for name in columns if name not in (reader.fieldnames or ())]
    if missing:
        raise InputError(f"Expected the columns {','.join(columns)} in {path}, but {', '.join(missing)} is missing.")
    return [{name: row[name] or "" for name in columns} for row in reader]


def _numbers(path: Path, rows: list[dict[str, str]], columns: Sequence[str]) -> FloatArray:
    table = np.zeros((len(rows), len(columns)))
    for i, row in enumerate(rows):
        for j, name in enumerate(columns):
            try:
                table[i, j] = float(row.get(name, ""))
            except ValueError:
                raise InputError(
                    f"Expected a number for {name} in row {i + 1} of {path}, got {row.get(name)!r}. Correct the row."
                ) from None
    odd = np.argwhere(~np.isfinite(table))
    if len(odd):
        row, column = odd[0]
        raise InputError(
            f"Expected finite numbers in {path}, got {table[row, column]} for {columns[column]} in row {row + 1}. "
            "Correct the table."
        )
    return table
