"""Boxes of tracks over the frames of a video, in one table for all sources.

Readers turn evidence, ground truth, result files, imported and corrected annotations into a ``TrackTable``. Code that
measures, compares and writes takes only this type.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.geometry.boxes import area, clip
from tsr_engine.json_shapes import JsonObject
from tsr_engine.records import FloatArray, Source

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

NO_CLASS: Final = -1
"""Class of a sign that has no class of the set, or that was not recognised."""
SOURCES: Final[tuple[Source, ...]] = ("detected", "predicted", "relocalised")
"""Sources of the engine's boxes."""
NO_SOURCE: Final = -1
"""Source of a box that the engine did not make."""

_UNSET: Any = None  # Any: a field holds it only until ``__post_init__``
"""Default of an optional column: every row gets its value of ``_UNKNOWN``."""
_UNKNOWN: Final[JsonObject] = {
    "class_id": NO_CLASS,
    "score": np.nan,
    "visibility": 1.0,
    "source": NO_SOURCE,
    "ignore": False,
    "occluded": False,
    "key": False,
}
_TYPES: Final[dict[str, type[np.generic]]] = {
    "frame": np.int64, "track": np.int64, "boxes": np.float64, "class_id": np.int64, "score": np.float64,
    "visibility": np.float64, "source": np.int64, "ignore": np.bool_, "occluded": np.bool_, "key": np.bool_,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class TrackTable:
    """Boxes of the tracks of one video, one row for each track and frame. Columns are read only.

    Attributes:
        frame: shape (n,), int64, ordinals from 0.
        track: shape (n,), int64, number of the track; its index in ``names`` if tracks have names.
        boxes: shape (n, 4), float64, ``x1, y1, x2, y2``, px.
        class_id: shape (n,), int64; unset: ``NO_CLASS``.
        score: shape (n,), float64; NaN: no score; unset: NaN.
        visibility: shape (n,), float64, visible share in [0, 1]; unset: 1.
        source: shape (n,), int64, index in ``sources``; unset: ``NO_SOURCE``.
        ignore: shape (n,), bool: counts neither as a miss nor as a false positive; unset: False.
        occluded: shape (n,), bool: marked as occluded; unset: False.
        key: shape (n,), bool: a keyframe, not interpolated; unset: False.
        names: name of each track, in the order of their numbers; empty: tracks have only numbers.
        sources: words that ``source`` refers to: ``SOURCES``, then words of other trackers.

    Raises:
        ValueError: a column has another shape, or a type that cannot become its type without loss.
    """

    frame: IntArray
    track: IntArray
    boxes: FloatArray
    class_id: IntArray = _UNSET
    _: KW_ONLY
    score: FloatArray = _UNSET
    visibility: FloatArray = _UNSET
    source: IntArray = _UNSET
    ignore: BoolArray = _UNSET
    occluded: BoolArray = _UNSET
    key: BoolArray = _UNSET
    names: tuple[str, ...] = ()
    sources: tuple[str, ...] = SOURCES

    def __post_init__(self) -> None:
        n = len(self.frame)
        for name, kind in _TYPES.items():
            given = getattr(self, name)
            column = np.broadcast_to(np.array(_UNKNOWN[name], kind), n) if given is None else np.asarray(given)
            shape = (n, 4) if name == "boxes" else (n,)
            if column.shape != shape or not np.can_cast(column.dtype, kind):
                raise ValueError(
                    f"TrackTable.{name} must have shape {shape} and type {np.dtype(kind)}. Got {column.shape} and "
                    f"{column.dtype} instead."
                )
            column = column.astype(kind, copy=False).view()
            column.flags.writeable = False
            object.__setattr__(self, name, column)

    def __len__(self) -> int:
        return len(self.frame)

    @classmethod
    def empty(cls) -> TrackTable:
        """No boxes."""
        none = np.zeros(0, np.int64)
        return cls(none, none, np.zeros((0, 4)))

    @classmethod
    def joined(cls, tables: Iterable[TrackTable], names: tuple[str, ...] = ()) -> TrackTable:
        """The rows of several tables with one numbering of tracks, one table after another.

        Raises:
            ValueError: the tables have different ``sources``.
        """
        parts = list(tables) or [cls.empty()]
        if any(part.sources != parts[0].sources for part in parts):
            raise ValueError(f"Tables must have one list of sources. Got {sorted({part.sources for part in parts})}.")
        columns: JsonObject = {name: np.concatenate([getattr(part, name) for part in parts]) for name in _TYPES}
        return cls(**columns, names=names, sources=parts[0].sources)

    @classmethod
    def of_rows(cls, rows: Iterable[tuple[int, int, FloatArray | tuple[float, ...], int, float, str]]) -> TrackTable:
        """A table of rows ``frame, track, box, class_id, score, source``, in their order."""
        row_list = list(rows)
        frame, track, boxes, class_id, score, sources = zip(*row_list, strict=True) if row_list else [()] * 6
        return cls(
            np.array(frame, np.int64),
            np.array(track, np.int64),
            np.array(boxes, np.float64).reshape(-1, 4),
            class_id=np.array(class_id, np.int64),
            score=np.array(score, np.float64),
        ).with_sources(sources)

    def with_sources(self, row_sources: Sequence[str]) -> TrackTable:
        """The same rows with new sources, one word for each row."""
        names = tuple(dict.fromkeys((*SOURCES, *row_sources)))
        index = {word: number for number, word in enumerate(names)}
        return replace(self, source=np.array([index[word] for word in row_sources], np.int64), sources=names)

    def source_words(self) -> list[str]:
        """The source of each row as a word; an empty word for ``NO_SOURCE``."""
        return ["" if number == NO_SOURCE else self.sources[number] for number in self.source.tolist()]

    def rows(self, index: slice | IntArray | BoolArray) -> TrackTable:
        """The rows that a NumPy index or mask selects, in its order."""
        return replace(self, **{name: getattr(self, name)[index] for name in _TYPES})

    def ordered(self) -> TrackTable:
        """The rows sorted by frame, then by track."""
        return self.rows(np.lexsort((self.track, self.frame)))

    def within(self, start: int, stop: int) -> TrackTable:
        """The rows with ``start <= frame < stop``; the table must be sorted by frame."""
        return self.rows(slice(*np.searchsorted(self.frame, [start, stop])))

    def inside(self, width: int, height: int) -> TrackTable:
        """The boxes clipped to a picture of width x height px, without those wholly outside."""
        cut = self.cut(width, height)
        return cut.rows(area(cut.boxes) > 0)

    def cut(self, width: int, height: int) -> TrackTable:
        """The boxes clipped to a picture of width x height px; those wholly outside keep a row without area.

        Annotations of real drives end at the picture's edge; exact ground truth and a tracker's boxes do not.
        """
        return replace(self, boxes=clip(self.boxes, width, height))

    def by_frame(self) -> Iterator[tuple[int, slice]]:
        """Each frame that has boxes, with the slice of its rows; the table must be sorted by frame."""
        if len(self):
            bounds = np.concatenate(([0], np.flatnonzero(np.diff(self.frame)) + 1, [len(self)])).tolist()
            for start, stop in pairwise(bounds):
                yield int(self.frame[start]), slice(start, stop)
