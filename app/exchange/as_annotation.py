"""Tracks of a data set as documents of a run: what somebody has drawn in another tool becomes people's word here.

A track that is one of the run's says what that track shall show; what it shows already stays as it is. In an
export of the same run it is the one of the same name. In every other file names are somebody else's (each run has an
``m1``), so boxes have to agree. Every other track becomes a new one. Tracks that the file does not have stay as they
are.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from uuid import uuid4

from app.edits.documents import TrackDoc, engine_doc
from app.exchange.laid_over import Alike, alike, as_shown, key_frames_of, laid_over, whole_label
from app.exchange.machine import engine_label
from app.exchange.marks import REVIEWS, new_notes
from app.exchange.same_sign import lying_on, touching
from tsr_engine.exchange.dataset import Skipped, Track
from tsr_engine.exchange.filters import part_of

__all__ = ["THIN_PX", "Annotated", "annotate"]

THIN_PX = 0.5
"""Tracks with a box of their own in every frame are thinned so that no edge moves by more, px."""


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
    labels: Mapping[int, int] = MappingProxyType({}),
) -> Annotated:
    """The documents that make a run show what the tracks say.

    Args:
        tracks: of the file.
        shown: what the run shows now, by name.
        present: its documents, by key.
        author: for notes.
        size: width and height of the picture, px; imports are cut at its edges.
        exported: the file is an export of this run, so that names alone say which track is which.
        labels: the engine's class of each track that has a document, by number; -1: never recognised.
    """
    found = Annotated()
    thinned = 0
    counted, ignored = _counted(tracks)
    for track, own in zip(counted, _own(counted, shown, present, exported), strict=True):
        known = own is not None
        base = _base(own, shown, present)
        over = None if own is None or base is None else alike(track, shown[own], base, size, THIN_PX)
        if own is not None and over is not None and _same(track, shown[own], over):
            found.same += 1
            continue
        key = _fresh() if own is None else own
        old = present.get(key, TrackDoc(key=key))
        if base is None or over is None or over.run is None:
            document, thinner = _made(key, track, engine_label(old, labels))
        else:
            engine = shown[key].label if base.class_id is None else engine_label(base, labels)
            document, thinner = laid_over(track, over, base, engine, THIN_PX)
        document = _judged(document, track, old, author)
        if key in present and present[key].same(document):  # brought in before
            found.same += 1
            continue
        found.documents[key] = document
        thinned += thinner
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


def _same(track: Track, shown: Track, found: Alike) -> bool:
    """Whether a track of the run shows already what the file says, as far as a file can say it."""
    judged = track.state in REVIEWS and track.state not in ("open", shown.state)
    return not judged and as_shown(track, found)


def _made(key: str, track: Track, engine: int | None) -> tuple[TrackDoc, bool]:
    """A document that shows the track by its key frames alone, and whether boxes were thinned to these.

    ``engine`` is the engine's class of the track of that key, which is nobody's word; None: it is a person's track.
    """
    keys, thinned = key_frames_of(track, THIN_PX, track.label)
    said = whole_label(track)
    return TrackDoc(key=key, class_id=None if said == engine else said, keys=keys), thinned


def _judged(document: TrackDoc, track: Track, old: TrackDoc, author: str) -> TrackDoc:
    """The document with what the file says of the whole track; what it does not say stays."""
    state = track.state if track.state in REVIEWS else "open"
    return document.model_copy(
        update={
            "revision": old.revision,
            "review": old.review if state == "open" else state,
            "not_a_sign": old.not_a_sign and state in ("open", "rejected"),
            "notes": (*old.notes, *new_notes(track.notes, author, old)),
        }
    )


def _base(own: str | None, shown: Mapping[str, Track], present: Mapping[str, TrackDoc]) -> TrackDoc | None:
    """The document that shows a track of the run; None: it shows nothing."""
    if own is None or own not in shown:
        return None
    frames = shown[own].frames
    return present[own] if own in present else engine_doc(int(own[1:]), int(frames[0]), int(frames[-1]))


def _fresh() -> str:
    return f"h{uuid4().hex[:16]}"
