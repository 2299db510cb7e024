"""Merges a file's track into a track of the run; the document stays unchanged in frames that are equal.

A box that comes back unchanged is no correction: it still comes from the engine, with its source, score and lanes, or
from the person who set it. Key frames are made in frames that differ, and at the ends of an interpolation that is cut.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from app.edits.documents import KeyFrame, Segment, TrackDoc
from app.edits.effective import effective_track
from tsr_engine.exchange.attributes import frame_values
from tsr_engine.exchange.dataset import UNSTATED_LABEL, Track
from tsr_engine.exchange.filters import clip_track, select_frames
from tsr_engine.exchange.thinning import key_frames, run_bounds
from tsr_engine.labels.model import AttributeValue

_DECIMAL_ROUNDING_PX = 0.06
"""Rounding error of formats with two decimals or percents of the picture, px."""
_INTEGER_ROUNDING_PX = 0.51
"""Rounding error of formats with whole pixels, px."""
_INTERPOLATION_TOLERANCE_PX = 1.0
"""Tolerance of interpolated boxes: the export's thinning plus rounding, px."""

_KEEP, _FROM_FILE, _ABSENT = 0, 1, 2


@dataclass(frozen=True, slots=True)
class Match:
    """The frames in which the boxes of a file's track and a track of the run agree.

    Attributes:
        run: the run's track, cut at the edges of the picture as importers do; None: it lies outside.
        boxes: for each frame of the file's track, whether the run shows the same box, shape (n,).
    """

    run: Track | None
    boxes: NDArray[np.bool_]


def match(track: Track, shown: Track, base: TrackDoc, size: tuple[int, int], thin_px: float) -> Match:
    """Compare the boxes of two tracks within the precision of a file.

    Args:
        track: track of the file.
        shown: track of the run as displayed.
        base: its document.
        size: width and height of the picture, px.
        thin_px: maximum move of an edge between key frames by the import's thinning, px.
    """
    run, _ = clip_track(shown, size)
    same = np.zeros(len(track.frames), np.bool_)
    if run is not None:
        _, in_file, in_run = np.intersect1d(track.frames, run.frames, assume_unique=True, return_indices=True)
        distance = np.abs(track.boxes[in_file] - run.boxes[in_run]).max(axis=1, initial=0.0)
        rounding = _INTEGER_ROUNDING_PX if np.array_equal(track.boxes, np.rint(track.boxes)) else _DECIMAL_ROUNDING_PX
        interpolated = np.isin(run.frames[in_run], _interpolated_frames(base, shown))
        same[in_file] = distance <= np.where(
            track.key[in_file], rounding + thin_px * interpolated, _INTERPOLATION_TOLERANCE_PX
        )
    return Match(run, same)


def labels_of(track: Track) -> NDArray[np.int64]:
    """The label of each frame, -1: none of the classes, ``UNSTATED_LABEL``: the file has none; shape (n,)."""
    labels = np.full(len(track.frames), track.label) if track.labels is None else track.labels
    return labels if track.silent is None else np.where(track.silent, UNSTATED_LABEL, labels)


def whole_label(track: Track) -> int | None:
    """The label of the whole track, -1: none of the classes; None: the file has none in any frame."""
    return None if track.silent is not None and track.silent.all() else track.label


def shows_same(track: Track, found: Match) -> bool:
    """Whether the run shows the same boxes in the same frames, with the same hidden marks and the file's labels."""
    if found.run is None or not np.array_equal(track.frames, found.run.frames):
        return False
    file_labels = labels_of(track)
    labels = ((file_labels == labels_of(found.run)) | (file_labels == UNSTATED_LABEL)).all()
    answers = track.attributes.items() <= found.run.attributes.items() and all(
        name in found.run.changing and (values == found.run.changing[name]).all()
        for name, values in track.changing.items()
    )
    return bool(found.boxes.all() and labels and answers and np.array_equal(track.occluded, found.run.occluded))


def key_frames_of(track: Track, thin_px: float, label: int) -> tuple[dict[str, KeyFrame], bool]:
    """Make key frames that show a track, and say whether a box in every frame was thinned to them.

    Boxes are interpolated between key frames, except after the last one before a gap and the last of all.

    Args:
        track: track of the file.
        thin_px: maximum move of an edge, px.
        label: label of the whole track; key frames store only other labels.
    """
    dense = len(track.frames) > 2 and bool(track.key.all())
    keep = key_frames(replace(track, key=np.zeros_like(track.key)) if dense else track, thin_px)
    thinned = dense and not bool(keep.all())
    ends = np.zeros(len(track.frames), np.bool_)
    ends[run_bounds(track.frames)[1:] - 1] = True
    labels = labels_of(track)
    own = (labels != label) & (labels != UNSTATED_LABEL)
    keep = keep | own  # the label of a key frame applies to that frame only
    keys: dict[str, KeyFrame] = {}
    for i in np.flatnonzero(keep).tolist():
        x1, y1, x2, y2 = track.boxes[i].tolist()
        keys[str(int(track.frames[i]))] = KeyFrame(
            box=(x1, y1, x2, y2),
            occluded=bool(track.occluded[i]),
            interpolate=not ends[i],
            class_id=int(labels[i]) if own[i] else None,
            attributes=frame_values(track, i),
        )
    return keys, thinned


def merge_import(
    track: Track, found: Match, base: TrackDoc, engine: int | None, thin_px: float
) -> tuple[TrackDoc, bool]:
    """Make the document that shows the file's track and keeps what the run already shows.

    Args:
        track: track of the file.
        found: the frames in which both agree; ``run`` is not None.
        base: document of the run's track, not deleted.
        engine: the engine's class of it, -1: not classified; None: it has no engine track.
        thin_px: maximum move of an edge between key frames, px.

    Returns:
        The document, and whether boxes of the file were thinned to key frames.
    """
    assert found.run is not None
    run = found.run
    first, last = int(track.frames[0]), int(track.frames[-1])
    frames = base.frames()
    # frames before the file's first or after its last frame are removed
    cut_before, cut_after = int(run.frames[0]) < first, int(run.frames[-1]) > last
    ends_outside = not (frames and frames[-1] > last) and _is_outside(base, last)
    segments = _clip_segments(base.segments, first if cut_before else 0, last if cut_after or ends_outside else None)
    start = first if cut_before else min([first, *frames])
    stop = last + 1 if cut_after else max([last, *frames]) + 1
    file_label = whole_label(track)
    label = run.label if file_label is None else file_label
    builder = _KeyFrameBuilder(base, track, label)
    thinned = False
    for a, b, mode in _ranges(track, found, start, stop):
        if mode == _ABSENT:
            builder.hide(a)
        elif mode == _KEEP:
            builder.keep(a, b)
        else:
            part = select_frames(track, (a <= track.frames) & (track.frames <= b))
            assert part is not None
            keys, is_thinned = key_frames_of(part, thin_px, label)
            builder.keys |= keys
            thinned |= is_thinned
    # the engine's own class is no correction
    class_id = base.class_id if label == run.label else None if label == engine else label
    return base.model_copy(update={"class_id": class_id, "segments": segments, "keys": builder.keys}), thinned


class _KeyFrameBuilder:
    """Collects the key frames, in order of frames."""

    def __init__(self, base: TrackDoc, track: Track, label: int) -> None:
        self.keys: dict[str, KeyFrame] = {}
        self._base = base
        self._frames = base.frames()
        self._shown: list[int] = track.frames.tolist()
        self._hidden = dict(zip(track.frames.tolist(), track.occluded.tolist(), strict=True))
        labels = zip(track.frames.tolist(), labels_of(track).tolist(), strict=True)
        self._labels = {f: c for f, c in labels if c != UNSTATED_LABEL}
        self._label = label
        self._answers = {f: frame_values(track, k) for k, f in enumerate(self._shown)} if track.changing else None
        turns = np.flatnonzero(np.diff(track.occluded, prepend=track.occluded[:1]))
        own = [f for f, c in self._labels.items() if c != label]
        for values in track.changing.values():
            own += track.frames[1:][values[1:] != values[:-1]].tolist()
        self._marked = sorted({*track.frames[turns].tolist(), *own})

    def hide(self, frame: int) -> None:
        """Show nothing from this frame to the next key frame."""
        self.keys[str(frame)] = KeyFrame(outside=True)

    def keep(self, a: int, b: int) -> None:
        """From ``a`` to ``b``, show the boxes of the document, hidden and labelled as in the file."""
        marked = {a, *(f for f in (*self._frames, *self._marked) if a <= f <= b)}
        # the hidden mark of a key frame without a box also applies to the next one with a box
        after = (self._shown[i] for f in marked if (i := bisect_left(self._shown, f)) < len(self._shown))
        for frame in sorted(marked | {f for f in after if f <= b}):
            wanted = self._at(frame, begins=frame == a)
            if wanted is not None:
                self.keys[str(frame)] = wanted
        last, line = self.keys.get(str(b)), self._base.line_at(b)
        if line is not None and (last is None or last.box is None):  # the line must not continue to the next key frame
            carried = self._last_key_frame()
            last = KeyFrame(occluded=carried.occluded, attributes=carried.attributes) if last is None else last
            self.keys[str(b)] = last.model_copy(update={"box": line, "interpolate": False})

    def _at(self, frame: int, *, begins: bool) -> KeyFrame | None:
        """The key frame that is needed there; None: the current values already apply."""
        own, carried = self._base.keys.get(str(frame)), self._last_key_frame()
        line = self._base.line_at(frame)
        # a line without an end would end at one of the new key frames
        continues = line is not None and self._base.line_at(frame + 1) is not None
        file_label = self._labels.get(frame)
        whole = None if own is None else own.class_id
        wanted = KeyFrame(
            box=line if own is None or begins else own.box,
            occluded=self._hidden.get(frame, carried.occluded if own is None else own.occluded),
            outside=_is_outside(self._base, frame),
            interpolate=continues and (own is None or own.interpolate),
            class_id=whole if file_label is None else file_label if file_label != self._label else None,
            attributes=self._attributes(frame),
        )
        is_needed = own is not None or (begins and line is not None) or wanted.class_id is not None
        as_carried = (wanted.outside, wanted.occluded, wanted.attributes) == (
            carried.outside,
            carried.occluded,
            carried.attributes,
        )
        return wanted if is_needed or not as_carried else None

    def _attributes(self, frame: int) -> dict[str, AttributeValue]:
        """The attributes from a frame on: the file's, or else the document's."""
        if self._answers is not None:
            return self._answers.get(frame, self._last_key_frame().attributes)
        before = self._base.last_key(frame)
        return {} if before is None else self._base.keys[str(before)].attributes

    def _last_key_frame(self) -> KeyFrame:
        return self.keys[next(reversed(self.keys))] if self.keys else KeyFrame()


def _ranges(track: Track, found: Match, start: int, stop: int) -> Iterator[tuple[int, int, int]]:
    """First frame, last frame and mode of each range in ``start <= frame < stop``, in order."""
    assert found.run is not None
    mode = np.full(stop - start, _KEEP)
    run_frames = found.run.frames[(start <= found.run.frames) & (found.run.frames < stop)]
    mode[run_frames - start] = _ABSENT
    mode[track.frames - start] = np.where(found.boxes, _KEEP, _FROM_FILE)
    bounds = [0, *(np.flatnonzero(np.diff(mode)) + 1).tolist(), len(mode)]
    for a, b in pairwise(bounds):
        yield start + a, start + b - 1, int(mode[a])


def _interpolated_frames(doc: TrackDoc, shown: Track) -> NDArray[np.int64]:
    """The frames with an interpolated box."""
    found = effective_track(doc, lambda _: (shown.frames, shown.boxes), int(shown.frames[-1]) + 1)
    interpolated: NDArray[np.int64] = found.frame[found.origin == 2]
    return interpolated


def _is_outside(doc: TrackDoc, frame: int) -> bool:
    """Whether the key frame that applies to the frame hides the track."""
    before = doc.last_key(frame)
    return before is not None and doc.keys[str(before)].outside


def _clip_segments(segments: tuple[Segment, ...], first: int, last: int | None) -> tuple[Segment, ...]:
    """The segments cut to ``first`` to ``last``; None: to their ends."""
    kept = []
    for piece in segments:
        low, high = max(piece.first, first), piece.last if last is None else min(piece.last, last)
        if low <= high:
            kept.append(piece.model_copy(update={"first": low, "last": high}))
    return tuple(kept)
