"""Reads columns of a store, for every view of a whole run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tsr_engine.evidence.columns import BOX, read_columns
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.labels.classes import RunClasses
from tsr_engine.track_table import TrackTable

IntColumn = NDArray[np.int64]
FloatColumn = NDArray[np.float64]


def confirmed_boxes(reader: EvidenceReader) -> TrackTable:
    """Read all boxes of the confirmed tracks of a run by frame, then by track, each with its track's fused class."""
    tracks = read_columns(reader, "tracks", "track_id", "class_id", confirmed=True)
    ids, labels = tracks.ints("track_id"), tracks.ints("class_id")
    rows = read_columns(
        reader, "track_frames", "frame", "track_id", *BOX, "source", alive=True, confirmed=True, order="any"
    )
    track, boxes = rows.ints("track_id"), rows.boxes()
    is_finite = np.isfinite(boxes).all(axis=1)
    order = np.flatnonzero(is_finite)[np.lexsort((track[is_finite], rows.ints("frame")[is_finite]))]
    index = np.searchsorted(ids, track[order])
    return TrackTable(
        frame=rows.ints("frame")[order],
        track=index,
        boxes=boxes[order],
        class_id=labels[index],
        source=rows.sources()[order],
        names=tuple(f"m{i}" for i in ids.tolist()),
    )


def labelled_boxes(table: TrackTable, classes: RunClasses, unmapped: Callable[[str], int] | None = None) -> TrackTable:
    """Replace the class numbers of a run's boxes by labels of a set.

    Args:
        table: with class numbers.
        classes: maps class numbers to labels.
        unmapped: maps the model's name of a class without a label in the set to a label number; unset: to -1.
    """
    labels = classes.to_labels(table.class_id)
    if unmapped is not None:
        for number in np.unique(table.class_id).tolist():
            if classes.is_unmapped(number):
                labels[table.class_id == number] = unmapped(classes.name(number))
    return replace(table, class_id=labels)


def tau_of(reader: EvidenceReader) -> float:
    """The gate's threshold in the run's parameters."""
    return float(reader.header.parameters["gate"]["tau"])


def measures_windows(reader: EvidenceReader) -> bool:
    """Whether the run measures a prediction that the gate rejects at the relocalised window, as in the paper."""
    return bool(reader.header.parameters["pipeline"]["rejected_measurement"] == "relocalised")


def symmetry_floor_of(reader: EvidenceReader) -> float:
    """The run's lower limit of the symmetry magnitude in the gate."""
    return float(reader.header.parameters["gate"]["symmetry_floor"])
