"""The sources of each confirmed track over time, as runs of equal source."""

from __future__ import annotations

import numpy as np

from app.body_model import Model
from tsr_engine.evidence.columns import read_columns
from tsr_engine.evidence.reader import EvidenceReader


class LaneColumns(Model):
    """The sources of each track over time: one entry per run of equal source, by track, then by frame."""

    track: list[int]
    first: list[int]
    last: list[int]
    """Inclusive."""
    source: list[int]
    """0 detected, 1 predicted, 2 relocalised."""


def lane_columns(reader: EvidenceReader) -> LaneColumns:
    """Runs of equal source in consecutive frames."""
    rows = read_columns(reader, "track_frames", "track_id", "frame", "source", alive=True, confirmed=True, order="any")
    table = np.stack([rows.ints("track_id"), rows.ints("frame"), rows.sources()])
    track, frame, source = table[:, np.lexsort((table[1], table[0]))]
    if not len(track):
        return LaneColumns(track=[], first=[], last=[], source=[])
    breaks = (np.diff(track) != 0) | (np.diff(frame) != 1) | (np.diff(source) != 0)
    starts = np.concatenate([[0], np.flatnonzero(breaks) + 1])
    ends = np.append(starts[1:], len(track)) - 1
    return LaneColumns(
        track=track[starts].tolist(),
        first=frame[starts].tolist(),
        last=frame[ends].tolist(),
        source=source[starts].tolist(),
    )
