"""The data set that every format writes and reads: videos with tracks, independent of any file format.

Frames are ordinals in presentation order from 0; boxes are edges ``x1, y1, x2, y2`` in px of the upright picture,
from 0, the right and lower edge exclusive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.labels.model import AttributeValue, LabelSet

__all__ = ["REJECTED", "UNSAID", "Dataset", "DatasetVideo", "Skipped", "Track"]

UNSAID = -2
"""In rows of a file that comes in: it says nothing about the class. Tracks have ``NO_CLASS`` and ``silent`` there."""
REJECTED = "rejected"
"""Review state of a track that is no sign: it teaches what fools the engine, and is never written as a sign."""


@dataclass(frozen=True, slots=True)
class Track:
    """A physical sign in a video.

    Attributes:
        uid: stable name of the track within its video (the review tool's key: ``m7``, ``h3f2...``).
        label: id of a label of the data set; -1: none of them, or not known.
        frames: frames that show it, strictly ascending, shape (n,).
        boxes: shape (n, 4), px edges; finite, ``x1 < x2`` and ``y1 < y2``.
        key: frames whose box was stated; the others can be interpolated, shape (n,).
        occluded: shape (n,).
        score: 0 to 1, NaN where there is none, shape (n,).
        labels: label of each frame where it differs from ``label``; None: it does not, else shape (n,).
        ignore: neither right nor wrong in an evaluation (a don't-care region), shape (n,); None: nowhere.
        silent: frames in which an imported file says nothing about the class, shape (n,); None: nowhere. The label is
            -1 there.
        state: how far review is: ``open``, ``accepted``, ``rejected``, ``needs_work`` or, of a truth, ``truth``.
        source: ``engine``, ``corrected``, ``human``, ``truth`` or ``imported``.
        notes: what people wrote: frame and text.
        attributes: answers to the questions of its label that hold for the whole track, by name.
        changing: answers that change from frame to frame, by name; None: there is none in that frame, shape (n,).
    """

    uid: str
    label: int
    frames: NDArray[np.int64]
    boxes: NDArray[np.float64]
    key: NDArray[np.bool_]
    occluded: NDArray[np.bool_]
    score: NDArray[np.float64]
    labels: NDArray[np.int64] | None = None
    ignore: NDArray[np.bool_] | None = None
    silent: NDArray[np.bool_] | None = None
    state: str = "open"
    source: str = "engine"
    notes: tuple[tuple[int, str], ...] = ()
    attributes: Mapping[str, AttributeValue] = field(default_factory=dict)
    changing: Mapping[str, NDArray[np.object_]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class DatasetVideo:
    """A video and its tracks.

    Attributes:
        name: file name, for people.
        sha256: of the file; empty: not known (an import).
        width: px, upright.
        height: px, upright.
        frames: frames that decode.
        rate: announced frames a second, exact; None: not known.
        times: presentation time of each frame in s, shape (frames,); None: not known.
        constant_rate: True: all frames lie ``1 / rate`` apart.
        tracks: makes a new pass over the tracks, in an order that does not change. Of an import, and of a data set
            that is to be exported, with those that people have rejected; what a format's writer gets has none.
        path: the file, where pictures are wanted.
        table: its frame table from an earlier pass: pictures of another file's frames are refused; None: not known.
        limits: what the file may demand; unset: ``VideoLimits()``.
        pixel_ratio: width of an upright pixel by its height; boxes are in stored pixels whatever it is.
        first: first frame that was looked at; frames outside ``first <= frame < stop`` say nothing about signs.
        stop: frame after the last that was looked at.
        provenance: for the manifest: run, engine, models, parameters, edit revision.
        negatives: what a format's writer must not take for signs: the tracks that people have rejected.
    """

    name: str
    sha256: str
    width: int
    height: int
    frames: int
    rate: Fraction | None
    times: NDArray[np.float64] | None
    constant_rate: bool
    tracks: Callable[[], Iterator[Track]]
    path: VideoSource | None = None
    first: int = 0
    stop: int = 0
    provenance: JsonMapping = field(default_factory=dict)
    negatives: tuple[Track, ...] = ()
    limits: VideoLimits | None = None
    table: FrameTable | None = None
    pixel_ratio: Fraction = Fraction(1)


@dataclass(frozen=True, slots=True)
class Skipped:
    """Something that was not exported or imported, and why."""

    what: str
    reason: str


@dataclass(frozen=True, slots=True)
class Dataset:
    """Videos under one label set.

    Attributes:
        labels: what the labels of tracks are ids of; of an import, with the labels and attributes that it adds.
        videos: in an order that does not change.
        skipped: what was left out on the way here.
        repaired: what was put right on the way here, one sentence each.
    """

    labels: LabelSet
    videos: Sequence[DatasetVideo]
    skipped: tuple[Skipped, ...] = ()
    repaired: tuple[str, ...] = ()
