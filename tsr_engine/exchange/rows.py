"""Tracks turned into rows of frames, for formats that list pictures and the boxes in them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tsr_engine.exchange.dataset import DatasetVideo, Track
from tsr_engine.exchange.thinning import key_frames
from tsr_engine.labels.model import AttributeValue

__all__ = ["FrameRows", "PlainRows", "TrackInfo", "rows_by_frame"]


@dataclass(frozen=True, slots=True)
class TrackInfo:
    """What rows say about their track."""

    uid: str
    label: int
    state: str
    source: str
    notes: tuple[tuple[int, str], ...]
    attributes: Mapping[str, AttributeValue]


@dataclass(frozen=True, slots=True)
class FrameRows:
    """All boxes of a video, sorted by frame, then by the order of the tracks.

    Attributes:
        tracks: by number.
        frame: shape (n,).
        track: number of the track, shape (n,).
        boxes: shape (n, 4), px edges.
        label: shape (n,), -1: not known.
        key: a key frame after thinning, shape (n,).
        occluded: shape (n,).
        score: NaN: none, shape (n,).
        ignore: shape (n,).
        changing: attributes that change from frame to frame, of each row; None: no track has any.
    """

    tracks: list[TrackInfo]
    frame: NDArray[np.int64]
    track: NDArray[np.int64]
    boxes: NDArray[np.float64]
    label: NDArray[np.int64]
    key: NDArray[np.bool_]
    occluded: NDArray[np.bool_]
    score: NDArray[np.float64]
    ignore: NDArray[np.bool_]
    changing: list[dict[str, AttributeValue]] | None = None

    def __len__(self) -> int:
        return len(self.frame)

    @property
    def frames(self) -> NDArray[np.int64]:
        """Frames with a box, ascending."""
        return np.unique(self.frame)

    def said(self, k: int) -> dict[str, AttributeValue]:
        """What the attributes that change say in a row."""
        return {} if self.changing is None else self.changing[k]

    def plain(self) -> PlainRows:
        """The columns as lists: a loop over rows in Python is several times as fast as over arrays."""
        return PlainRows(
            self.track.tolist(),
            self.label.tolist(),
            self.key.tolist(),
            self.occluded.tolist(),
            self.score.tolist(),
            self.ignore.tolist(),
        )

    def by_frame(self) -> Iterator[tuple[int, slice]]:
        """Each frame with a box, and where its rows lie."""
        if not len(self):
            return
        bounds = np.concatenate(([0], np.flatnonzero(np.diff(self.frame)) + 1, [len(self)])).tolist()
        for at, end in pairwise(bounds):
            yield int(self.frame[at]), slice(at, end)


class PlainRows(NamedTuple):
    """Columns of ``FrameRows`` as lists."""

    track: list[int]
    label: list[int]
    key: list[bool]
    occluded: list[bool]
    score: list[float]
    ignore: list[bool]


def rows_by_frame(
    video: DatasetVideo, *, thin_px: float = 0.0, rounding: float = 0.0, only: set[str] | None = None
) -> FrameRows:
    """Gather the boxes of a video by frame: about 70 bytes a box.

    Args:
        video: its tracks are read once.
        thin_px: ``key`` marks the frames that ``key_frames`` keeps within this bound; 0: all are key frames.
        rounding: passed to ``key_frames``.
        only: uids of the tracks wanted; None: all.
    """
    infos: list[TrackInfo] = []
    parts: list[tuple[NDArray[np.int64], Track, NDArray[np.bool_]]] = []
    for track in video.tracks():
        if only is not None and track.uid not in only:
            continue
        number = np.full(len(track.frames), len(infos), dtype=np.int64)
        infos.append(TrackInfo(track.uid, track.label, track.state, track.source, track.notes, track.attributes))
        parts.append((number, track, key_frames(track, thin_px, rounding=rounding)))
    number = _joined([n for n, _, _ in parts], np.int64)
    frame = _joined([t.frames for _, t, _ in parts], np.int64)
    order = np.lexsort((number, frame))
    labels = [np.full(len(t.frames), t.label, np.int64) if t.labels is None else t.labels for _, t, _ in parts]
    ignore = [np.zeros(len(t.frames), np.bool_) if t.ignore is None else t.ignore for _, t, _ in parts]
    boxes = np.concatenate([t.boxes for _, t, _ in parts]) if parts else np.zeros((0, 4))
    return FrameRows(
        infos,
        frame[order],
        number[order],
        boxes[order].astype(np.float64),
        _joined(labels, np.int64)[order],
        _joined([k for _, _, k in parts], np.bool_)[order],
        _joined([t.occluded for _, t, _ in parts], np.bool_)[order],
        _joined([t.score for _, t, _ in parts], np.float64)[order],
        _joined(ignore, np.bool_)[order],
        _changing([track for _, track, _ in parts], order.tolist()),
    )


def _changing(tracks: list[Track], order: list[int]) -> list[dict[str, AttributeValue]] | None:
    if not any(track.changing for track in tracks):
        return None
    rows: list[dict[str, AttributeValue]] = []
    for track in tracks:
        columns = [(name, values.tolist()) for name, values in track.changing.items()]
        rows += [
            {name: values[k] for name, values in columns if values[k] is not None} for k in range(len(track.frames))
        ]
    return [rows[k] for k in order]


def _joined(parts: list[Any], dtype: type[np.generic]) -> NDArray[Any]:
    return np.concatenate(parts).astype(dtype) if parts else np.zeros(0, dtype=dtype)
