"""Turns tracks into rows of frames, for formats that list pictures and their boxes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from tsr_engine.exchange.dataset import DatasetVideo, Track
from tsr_engine.exchange.thinning import key_frames
from tsr_engine.labels.model import AttributeValue
from tsr_engine.track_table import BoolArray, IntArray, TrackTable

Scalar = TypeVar("Scalar", bound=np.generic)


@dataclass(frozen=True, slots=True)
class TrackInfo:
    """Facts about a track that its rows share."""

    uid: str
    label: int
    state: str
    source: str
    notes: tuple[tuple[int, str], ...]
    attributes: Mapping[str, AttributeValue]


@dataclass(frozen=True, slots=True)
class FrameRows:
    """All boxes of a video with the facts about their tracks.

    Attributes:
        tracks: by track number.
        table: the boxes by frame, then by track; ``key`` marks key frames after thinning.
        changing: attributes of each row that change from frame to frame; None: no track has any.
    """

    tracks: list[TrackInfo]
    table: TrackTable
    changing: list[dict[str, AttributeValue]] | None = None

    @property
    def frames(self) -> IntArray:
        """Frames with a box, ascending."""
        return np.unique(self.table.frame)

    def attributes_at(self, k: int) -> dict[str, AttributeValue]:
        """The changing attributes of row ``k``."""
        return {} if self.changing is None else self.changing[k]

    def as_lists(self) -> RowLists:
        """The columns as lists: a Python loop over lists is several times as fast as over arrays."""
        return RowLists(*(getattr(self.table, name).tolist() for name in RowLists._fields))


class RowLists(NamedTuple):
    """Columns of a table as lists."""

    track: list[int]
    class_id: list[int]
    key: list[bool]
    occluded: list[bool]
    score: list[float]
    ignore: list[bool]


def rows_by_frame(
    video: DatasetVideo, *, thin_px: float = 0.0, rounding: float = 0.0, only: set[str] | None = None
) -> FrameRows:
    """Gather the boxes of a video by frame; takes about 70 bytes a box.

    Args:
        video: its tracks are read once.
        thin_px: bound in px for ``key_frames``, which sets ``key``; 0: all frames are key frames.
        rounding: passed to ``key_frames``.
        only: uids of the tracks to take; None: all.
    """
    tracks = [track for track in video.tracks() if only is None or track.uid in only]
    keys = [key_frames(track, thin_px, rounding=rounding) for track in tracks]
    table, order = _table(tracks, keys)
    infos = [TrackInfo(t.uid, t.label, t.state, t.source, t.notes, t.attributes) for t in tracks]
    return FrameRows(infos, table, _frame_attributes(tracks, order.tolist()))


def table_of(tracks: Sequence[Track]) -> TrackTable:
    """The boxes of tracks by frame, then by track; a track's number is its index."""
    return _table(tracks, [track.key for track in tracks])[0]


def _table(tracks: Sequence[Track], keys: Sequence[BoolArray]) -> tuple[TrackTable, IntArray]:
    """The table, and for each of its rows the index among the concatenated rows of all tracks."""
    frame = _joined([t.frames for t in tracks], np.int64)
    number = np.repeat(np.arange(len(tracks)), [len(t.frames) for t in tracks])
    order = np.lexsort((number, frame))
    labels = [np.full(len(t.frames), t.label, np.int64) if t.labels is None else t.labels for t in tracks]
    ignore = [np.zeros(len(t.frames), np.bool_) if t.ignore is None else t.ignore for t in tracks]
    boxes = np.concatenate([np.zeros((0, 4)), *(t.boxes for t in tracks)])
    table = TrackTable(
        frame=frame[order],
        track=number[order],
        boxes=boxes[order],
        class_id=_joined(labels, np.int64)[order],
        score=_joined([t.score for t in tracks], np.float64)[order],
        ignore=_joined(ignore, np.bool_)[order],
        occluded=_joined([t.occluded for t in tracks], np.bool_)[order],
        key=_joined(keys, np.bool_)[order],
    )
    return table, order


def _frame_attributes(tracks: list[Track], order: list[int]) -> list[dict[str, AttributeValue]] | None:
    if not any(track.changing for track in tracks):
        return None
    rows: list[dict[str, AttributeValue]] = []
    for track in tracks:
        columns = [(name, values.tolist()) for name, values in track.changing.items()]
        rows += [
            {name: values[k] for name, values in columns if values[k] is not None} for k in range(len(track.frames))
        ]
    return [rows[k] for k in order]


def _joined(parts: Sequence[NDArray[Scalar]], dtype: type[Scalar]) -> NDArray[Scalar]:
    return np.concatenate([np.zeros(0, dtype), *parts])
