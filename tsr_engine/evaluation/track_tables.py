"""Reads the tables for the evaluation of tracking: ground truth and the result rows of ``tsr track --csv``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from tsr_engine.errors import InputError
from tsr_engine.evaluation.box_tables import RowError, read_mot_table, read_result_table, read_truth_table
from tsr_engine.evidence.reader import ResultRow
from tsr_engine.records import FloatArray
from tsr_engine.track_table import TrackTable


def truth_table(columns: FloatArray) -> TrackTable:
    """Ground truth from an array (n, 9) with the columns of ``box_tables.TRUTH_COLUMNS``."""
    return TrackTable(
        frame=columns[:, 0].astype(np.int64),
        track=columns[:, 1].astype(np.int64),
        boxes=columns[:, 2:6].copy(),
        class_id=columns[:, 6].astype(np.int64),
        visibility=columns[:, 7].copy(),
        ignore=columns[:, 8] != 0,
    )


def result_table(rows: Iterable[ResultRow]) -> TrackTable:
    """Results from the rows of a run."""
    return TrackTable.of_rows((r.frame, r.track_id, r[2:6], r.class_id, r.score, r.source) for r in rows)


def every_nth_frame(truth: TrackTable, step: int) -> TrackTable:
    """The rows of every ``step``-th frame from frame 0, with the frames renumbered."""
    here = truth.rows(truth.frame % step == 0)
    return replace(here, frame=here.frame // step)


def read_clip_truth(path: Path, frames: int | None = None) -> TrackTable:
    """Read ground truth from a CSV with the columns ``frame,track_id,x1,y1,x2,y2,class_id,visibility,ignore``.

    Args:
        path: the file.
        frames: number of frames of the video; unset: any frame is valid.

    Raises:
        InputError: the file or a column is missing, or a row breaks a rule of :mod:`~.box_tables`.
    """
    with _naming_file(path):
        return truth_table(read_truth_table(_content(path), frames))


def read_mot_truth(path: Path) -> TrackTable:
    """Read ground truth from MOTChallenge rows ``frame,id,left,top,width,height,flag,class_id,visibility``.

    Frames count from 1 in the file. A flag of 0 marks a row to ignore.

    Raises:
        InputError: the file is missing, or a row breaks a rule of :mod:`~.box_tables`.
    """
    with _naming_file(path):
        table = read_mot_table(_content(path))
    boxes = np.concatenate([table[:, 2:4], table[:, 2:4] + table[:, 4:6]], axis=1)
    return TrackTable(
        frame=table[:, 0].astype(np.int64) - 1,
        track=table[:, 1].astype(np.int64),
        boxes=boxes,
        class_id=table[:, 7].astype(np.int64),
        visibility=table[:, 8].copy(),
        ignore=table[:, 6] == 0,
    )


def read_results(path: Path) -> TrackTable:
    """Read results from the CSV of ``tsr track`` or ``tsr replay``.

    Raises:
        InputError: the file or a column is missing, or a row breaks a rule of :mod:`~.box_tables`.
    """
    with _naming_file(path):
        table, source = read_result_table(_content(path))
    return TrackTable(
        frame=table[:, 0].astype(np.int64),
        track=table[:, 1].astype(np.int64),
        boxes=table[:, 2:6].copy(),
        class_id=table[:, 6].astype(np.int64),
        score=table[:, 7].copy(),
    ).with_sources(source)


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"Expected a readable text table at {path}, got: {error.strerror}. Check the path.") from None


@contextmanager
def _naming_file(path: Path) -> Iterator[None]:
    """Turn a broken rule into an error that names the file."""
    try:
        yield
    except RowError as error:
        raise InputError(f"{path}, line {error.line}: {error.rule}. Correct the table.") from None
