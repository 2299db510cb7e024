"""Tracks of a data set as documents of a run: what somebody has drawn in another tool becomes people's word here.

A track that is one of the run's says what that track shall show; where it shows that already, nothing happens. In an
export of the same run it is the one of the same name. In every other file names are somebody else's (each run has an
``m1``), so boxes have to agree. Every other track becomes a new one. Tracks that the file does not have stay as they
are.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from app.edits.documents import KeyFrame, TrackDoc
from app.exchange.marks import REVIEWS, new_notes
from app.exchange.same_sign import lying_on, touching
from tsr_engine.exchange.dataset import Skipped, Track
from tsr_engine.exchange.filters import part_of
from tsr_engine.exchange.thinning import key_frames, runs_of

__all__ = ["THIN_PX", "Annotated", "annotate"]

THIN_PX = 0.5
"""Tracks with a box of their own in every frame are thinned so that no edge moves by more, px."""
_WRITTEN_PX = 0.06
"""What formats with two decimals or percents of the picture lose, px."""
_WHOLE_PX = 0.51
"""What formats with whole pixels lose, px."""
_DRAWN_PX = 1.0
"""By how much interpolated boxes may differ from ours: what thinning lost on the way out and what rounding adds, px."""


@dataclass(slots=True)
class Annotated:
    """What became of the tracks.

    Attributes:
        documents: those to store, by key.
        changed: tracks of the run that now show something else.
        made: new tracks.
        same: tracks of the run that showed it already.
        boxes: boxes of the changed and the new tracks.
        repaired: what was put right, one sentence each.
        skipped: what has no place in an annotation.
    """

    documents: dict[str, TrackDoc] = field(default_factory=dict)
    changed: int = 0
    made: int = 0
    same: int = 0
    boxes: int = 0
    repaired: list[str] = field(default_factory=list)
    skipped: list[Skipped] = field(default_factory=list)


def annotate(
    tracks: Iterable[Track],
    shown: Mapping[str, Track],
    present: Mapping[str, TrackDoc],
    author: str,
    size: tuple[int, int],
    exported: bool = False,
) -> Annotated:
    """The documents that make a run show what the tracks say.

    Args:
        tracks: of the file.
        shown: what the run shows now, by name.
        present: its documents, by key.
        author: for notes.
        size: width and height of the picture, px; imports are cut at its edges.
        exported: the file is an export of this run, so that names alone say which track is which.
    """
    found = Annotated()
    thinned = 0
    counted, ignored = _counted(tracks)
    for track, own in zip(counted, _own(counted, shown, present, exported), strict=True):
        known = own is not None
        if own is not None and own in shown and _same(track, shown[own], size):
            found.same += 1
            continue
        key = _fresh() if own is None else own
        dense = len(track.frames) > 2 and bool(track.key.all())
        keep = key_frames(replace(track, key=np.zeros_like(track.key)) if dense else track, THIN_PX)
        document = _document(key, track, keep, present.get(key), author)
        if key in present and present[key].same(document):  # brought in before
            found.same += 1
            continue
        found.documents[key] = document
        thinned += dense and not keep.all()
        found.boxes += len(track.frames)
        found.changed += known
        found.made += not known
    if thinned:
        one = "1 track with a box of its own in every frame was"
        dense_ones = one if thinned == 1 else f"{thinned} tracks with a box of their own in every frame were"
        found.repaired.append(f"{dense_ones} thinned to key frames; no edge moves by more than {THIN_PX} px.")
    if ignored:
        found.skipped.append(Skipped(f"{ignored} boxes that are to be ignored", "an annotation has no such regions"))
    return found


def _counted(tracks: Iterable[Track]) -> tuple[list[Track], int]:
    """The tracks without what is to be ignored, and how many boxes that is."""
    kept: list[Track] = []
    ignored = 0
    for track in tracks:
        part: Track | None = track
        if track.ignore is not None and track.ignore.any():
            ignored += int(track.ignore.sum())
            part = part_of(replace(track, ignore=None), ~track.ignore)
        if part is not None:
            kept.append(part)
    return kept, ignored


def _own(
    tracks: list[Track], shown: Mapping[str, Track], present: Mapping[str, TrackDoc], exported: bool
) -> list[str | None]:
    """The run's track that each track is about: by name, else by where it lies; None: a new one."""
    names: list[str | None] = []
    used: set[str] = set()
    for track in tracks:
        ours = track.uid in shown or track.uid in present
        if ours and not exported:
            ours = track.uid in shown and touching(track, shown[track.uid])
        mine = track.uid if ours and track.uid not in used else None
        names.append(mine)
        used |= set() if mine is None else {mine}
    strangers = [i for i, name in enumerate(names) if name is None]
    left = {name: track for name, track in shown.items() if name not in used and track.state != "rejected"}
    for place, name in lying_on([tracks[i] for i in strangers], left).items():
        names[strangers[place]] = name
    return names


def _same(track: Track, shown: Track, size: tuple[int, int]) -> bool:
    """Whether a track of the run shows already what the file says, as far as a file can say it."""
    edges = np.array([*size, *size], np.float64)
    cut = np.clip(shown.boxes, 0.0, edges)
    inside = part_of(replace(shown, boxes=cut), (cut[:, 2] > cut[:, 0]) & (cut[:, 3] > cut[:, 1]))
    if inside is None:
        return False
    shown = inside
    if not np.array_equal(track.frames, shown.frames) or not np.array_equal(track.occluded, shown.occluded):
        return False
    said = _labels(track)
    if ((said != _labels(shown)) & (said >= 0)).any():
        return False
    if track.state in REVIEWS and track.state not in ("open", shown.state):
        return False
    far = np.abs(track.boxes - shown.boxes).max(axis=1)
    written = _WHOLE_PX if np.array_equal(track.boxes, np.rint(track.boxes)) else _WRITTEN_PX
    return bool((far[track.key] <= written).all() and (far <= _DRAWN_PX).all())


def _labels(track: Track) -> NDArray[np.int64]:
    return np.full(len(track.frames), track.label) if track.labels is None else track.labels


def _document(key: str, track: Track, keep: NDArray[np.bool_], present: TrackDoc | None, author: str) -> TrackDoc:
    """A document that shows the track by its key frames alone.

    Lines run between key frames; the last one before a gap, and the last of all, holds no line.
    """
    ends = np.zeros(len(track.frames), np.bool_)
    ends[runs_of(track.frames)[1:] - 1] = True
    labels = _labels(track)
    keep = keep | ((labels != track.label) & (labels >= 0))  # a label of its own holds for one key frame alone
    keys: dict[str, KeyFrame] = {}
    for i in np.flatnonzero(keep).tolist():
        x1, y1, x2, y2 = track.boxes[i].tolist()
        keys[str(int(track.frames[i]))] = KeyFrame(
            box=(x1, y1, x2, y2),
            occluded=bool(track.occluded[i]),
            interpolate=not ends[i],
            class_id=int(labels[i]) if labels[i] != track.label and labels[i] >= 0 else None,
        )
    old = TrackDoc(key=key) if present is None else present
    state = track.state if track.state in REVIEWS else "open"
    return TrackDoc(
        key=key,
        revision=old.revision,
        class_id=track.label if track.label >= 0 else None,
        review=old.review if state == "open" else state,  # type: ignore[arg-type]
        not_a_sign=old.not_a_sign and state in ("open", "rejected"),
        keys=keys,
        notes=(*old.notes, *new_notes(track.notes, author, old)),
    )


def _fresh() -> str:
    return f"h{uuid4().hex[:16]}"
