"""What a track shows in each frame: its document over the engine's boxes. The page: static/js/model/effective.js."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from app.edits.documents import TrackDoc

__all__ = ["Effective", "EffectiveTrack", "box_at", "effective_track"]

Edges = tuple[float, float, float, float]
Origin = Literal["engine", "corrected", "interpolated"]


@dataclass(frozen=True, slots=True)
class Effective:
    """A track in one frame."""

    box: Edges
    origin: Origin
    occluded: bool
    class_id: int | None
    """As people say; None: the engine's label stands."""


@dataclass(frozen=True, slots=True)
class EffectiveTrack:
    """A track in all frames that show it, in order.

    Attributes:
        frame: shape (n,).
        boxes: shape (n, 4), px.
        class_id: shape (n,), -1: the engine's label stands.
        origin: shape (n,), 0 engine, 1 corrected, 2 interpolated.
        occluded: shape (n,).
    """

    frame: NDArray[np.int64]
    boxes: NDArray[np.float64]
    class_id: NDArray[np.int64]
    origin: NDArray[np.int64]
    occluded: NDArray[np.bool_]


_ORIGINS: tuple[Origin, ...] = ("engine", "corrected", "interpolated")


def box_at(doc: TrackDoc, frame: int, machine: Callable[[int, int], Edges | None]) -> Effective | None:
    """What a track shows in a frame.

    Args:
        doc: the document.
        frame: ordinal.
        machine: (track, frame) -> the engine's box, or None.
    """
    if doc.gone:
        return None
    before = doc.last_key(frame)
    state = None if before is None else doc.keys[str(before)]
    if state is not None and state.outside:
        return None
    occluded = state is not None and state.occluded
    own = doc.keys.get(str(frame))
    label = doc.class_id if own is None or own.class_id is None else own.class_id
    line = doc.line_at(frame)
    if line is not None:
        return Effective(line, "interpolated" if own is None or own.box is None else "corrected", occluded, label)
    segment = next((s for s in doc.segments if s.first <= frame <= s.last), None)
    box = None if segment is None else machine(segment.track, frame)
    return None if box is None else Effective(box, "engine", occluded, label)


def effective_track(
    doc: TrackDoc, machine: Callable[[int], tuple[NDArray[np.int64], NDArray[np.float64]]]
) -> EffectiveTrack:
    """A track in all its frames.

    Args:
        doc: the document.
        machine: track -> its frames, ascending, shape (n,), and boxes, shape (n, 4).
    """
    boxes: dict[int, Edges] = {}
    for segment in doc.segments:
        frames, table = machine(segment.track)
        rows = slice(*np.searchsorted(frames, [segment.first, segment.last + 1]))
        for frame, (x1, y1, x2, y2) in zip(frames[rows].tolist(), table[rows].tolist(), strict=True):
            boxes[frame] = (x1, y1, x2, y2)
    keys = doc.frames()
    frames_all = sorted({*boxes, *range(keys[0], keys[-1] + 1)}) if keys else sorted(boxes)
    if not keys:  # nothing said about single frames: no need to look at each
        shown = [] if doc.gone else [Effective(boxes[f], "engine", False, doc.class_id) for f in frames_all]
        at = [] if doc.gone else frames_all
    else:
        found = [(f, box_at(doc, f, lambda _track, frame: boxes.get(frame))) for f in frames_all]
        at = [f for f, one in found if one is not None]
        shown = [one for _, one in found if one is not None]
    return EffectiveTrack(
        frame=np.array(at, np.int64),
        boxes=np.array([one.box for one in shown], np.float64).reshape(-1, 4),
        class_id=np.array([-1 if one.class_id is None else one.class_id for one in shown], np.int64),
        origin=np.array([_ORIGINS.index(one.origin) for one in shown], np.int64),
        occluded=np.array([one.occluded for one in shown], np.bool_),
    )
