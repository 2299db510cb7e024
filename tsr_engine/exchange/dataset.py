"""Defines the data set that every format writes and reads: videos with tracks, independent of any file format.

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

UNSTATED_LABEL = -2
"""Label of a row in an imported file that states no class. Tracks have ``NO_CLASS`` and ``silent`` there."""
REJECTED = "rejected"
"""Review state of a track that is not a sign: a hard negative for training, never written as a sign."""


@dataclass(frozen=True, slots=True)
class Track:
    """A physical sign in a video; n is its number of frames.

    Attributes:
        uid: name of the track, unique and stable within its video (the review tool's key: ``m7``, ``h3f2...``).
        label: id of a label of the data set; -1: none, or not known.
        frames: frames that show the sign, strictly ascending, shape (n,).
        boxes: shape (n, 4), px edges; finite, ``x1 < x2`` and ``y1 < y2``.
        key: frames whose box is stated; the others may be interpolated, shape (n,).
        occluded: shape (n,).
        score: 0 to 1, NaN: none, shape (n,).
        labels: label of each frame, shape (n,); None: every frame has ``label``.
        ignore: regions that an evaluation skips (don't care), shape (n,); None: none.
        silent: frames for which an imported file states no class and the label is -1, shape (n,); None: none.
        state: review state: ``open``, ``accepted``, ``rejected``, ``needs_work``, or ``truth`` for ground truth.
        source: ``engine``, ``corrected``, ``human``, ``truth`` or ``imported``.
        notes: people's notes, each a frame and a text.
        attributes: values that hold for the whole track, by attribute name.
        changing: values of each frame by attribute name, shape (n,); None: no value in that frame.
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
        sha256: hash of the file; empty: not known (an import).
        width: px of the upright picture.
        height: px of the upright picture.
        frames: number of frames that decode.
        rate: announced frames per second, exact; None: not known.
        times: presentation time of each frame in s, shape (frames,); None: not known.
        constant_rate: True: all frames lie ``1 / rate`` apart.
        tracks: makes a new pass over the tracks, always in the same order. An import, and a data set that is to be
            exported, include the rejected tracks; a format's writer gets the video without them.
        path: the video file, needed to export pictures.
        table: frame table from an earlier pass; frames that differ from it are refused; None: not known.
        limits: limits on the file; unset: ``VideoLimits()``.
        pixel_ratio: width of a pixel divided by its height, upright; boxes are always in stored pixels.
        first: first examined frame; frames outside ``first <= frame < stop`` say nothing about signs.
        stop: frame after the last examined one.
        provenance: run, engine, models, parameters and edit revision, for the manifest.
        negatives: rejected tracks, which a format's writer must not write as signs.
        left_out: tracks, or parts of them, that filters left out of an export: a retraining must not take their places
            for background.
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
    left_out: tuple[Track, ...] = ()
    limits: VideoLimits | None = None
    table: FrameTable | None = None
    pixel_ratio: Fraction = Fraction(1)


@dataclass(frozen=True, slots=True)
class Skipped:
    """Something that was not exported or imported, with the reason."""

    what: str
    reason: str


@dataclass(frozen=True, slots=True)
class Dataset:
    """Videos under one label set.

    Attributes:
        labels: the label set of the tracks; of an import, with the labels and attributes that it adds.
        videos: always in the same order.
        skipped: what was left out so far.
        repaired: what was repaired so far, one sentence each.
    """

    labels: LabelSet
    videos: Sequence[DatasetVideo]
    skipped: tuple[Skipped, ...] = ()
    repaired: tuple[str, ...] = ()
