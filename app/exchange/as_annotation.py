"""Converts tracks of a data set to documents of a run: annotations from another tool become corrections.

A track of the file that matches one of the run corrects it; frames that are equal already stay as they are. In an
export of the same run tracks match by name. In every other file each run has an ``m1``, so the boxes must agree. Every
other track becomes a new one. Tracks that the file lacks stay as they are, except engine tracks that a track of the
file covers besides its own: these are merged into it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from uuid import uuid4

from app.edits.documents import TrackDoc, engine_doc
from app.edits.track_name import track_name
from app.exchange.engine_tracks import EngineFacts, engine_label
from app.exchange.joined import joined
from app.exchange.marks import REVIEWS, new_notes
from app.exchange.marks import ignored as is_ignored
from app.exchange.merge_import import Match, as_shown, key_frames_of, match, merge_import, whole_label
from app.exchange.same_sign import covered_too, lying_on, touching
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
        merged: names of the run's tracks that became part of another, because the file has both as one.
        boxes: boxes of the changed and the new tracks.
        repaired: what was put right, one sentence each.
        skipped: what has no place in an annotation.
    """

    documents: dict[str, TrackDoc] = field(default_factory=dict)
    changed: int = 0
    made: int = 0
    same: int = 0
    merged: list[str] = field(default_factory=list)
    boxes: int = 0
    repaired: list[str] = field(default_factory=list)
    skipped: list[Skipped] = field(default_factory=list)

    def tell_covered(
        self, merged: Iterable[str], left: Iterable[str], document: TrackDoc, present: Mapping[str, TrackDoc]
    ) -> None:
        """Say what became of the run's tracks that a track of the file covers besides its own."""
        self.merged += [track_name(name, present.get(name)) for name in merged]
        for name in left:
            reason = (
                f"It lies on track {track_name(document.key, document)} as the file has it, but people have said "
                "something of it, so it stays. Merge the two, or reject one."
            )
            self.skipped.append(Skipped(f"track {track_name(name, present.get(name))} of the run", reason))


def annotate(
    tracks: Iterable[Track],
    shown: Mapping[str, Track],
    present: Mapping[str, TrackDoc],
    author: str,
    size: tuple[int, int],
    exported: bool = False,
    engine: Mapping[int, EngineFacts] = MappingProxyType({}),
) -> Annotated:
    """The documents that make a run show what the tracks say.

    Args:
        tracks: of the file.
        shown: what the run shows now, by name.
        present: its documents, by key.
        author: for notes.
        size: width and height of the picture, px; imports are cut at its edges.
        exported: the file is an export of this run, so that names alone say which track is which.
        engine: the engine's tracks, at least those that have a document, by number.
    """
    found = Annotated()
    thinned = 0
    counted, ignored = _counted(tracks)
    names = _own(counted, shown, present, exported)
    covered = covered_too(counted, names, shown)
    labels = {number: facts.label for number, facts in engine.items()}
    for place, (track, own) in enumerate(zip(counted, names, strict=True)):
        known = own is not None
        key = _fresh() if own is None else own
        parts = {name: _engines(name, present, engine, shown) for name in covered.get(place, [])}
        free = {name: doc for name, doc in parts.items() if doc is not None}
        base, run = _base(own, shown, present), shown.get(key)
        if base is not None and run is not None:
            base, run = joined(base, run, ((doc, shown[name]) for name, doc in free.items()))
        over = None if base is None or run is None else match(track, run, base, size, THIN_PX)
        old = present.get(key, TrackDoc(key=key))
        if run is not None and over is not None and not free and _same(track, run, over, old):
            found.same += 1
            continue
        if base is None or over is None or over.run is None:
            document, thinner = _made(key, track, engine_label(old, labels))
        else:
            own_label = shown[key].label if base.class_id is None else engine_label(base, labels)
            document, thinner = merge_import(track, over, base, own_label, THIN_PX)
        document = _judged(document, track, old, author)
        if key in present and present[key].same(document) and not free:  # brought in before
            found.same += 1
            continue
        found.documents[key] = document
        found.documents |= {n: d.model_copy(update={"gone": True, "merged_into": key}) for n, d in free.items()}
        found.tell_covered(free, [name for name, doc in parts.items() if doc is None], document, present)
        thinned += thinner
        found.boxes += len(track.frames)
        found.changed += known
        found.made += not known
    if found.merged:
        found.repaired.append(_merged_words(found.merged))
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
        if track.ignore is not None and track.ignore.any() and not is_ignored(track):
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


def _engines(
    name: str, present: Mapping[str, TrackDoc], engine: Mapping[int, EngineFacts], shown: Mapping[str, Track]
) -> TrackDoc | None:
    """The document of an engine track that nobody has touched; None: somebody has said something of it."""
    if name not in present:
        frames = shown[name].frames
        return engine_doc(int(name[1:]), int(frames[0]), int(frames[-1])) if name.startswith("m") else None
    facts = engine.get(int(name[1:])) if name.startswith("m") else None
    return present[name] if present[name].untouched(None if facts is None else facts.span) else None


def _merged_words(names: list[str]) -> str:
    """Which tracks of the run the file has as part of another."""
    most = 5
    more = f" and {len(names) - most} more" if len(names) > most else ""
    if len(names) == 1:
        return f"Track {names[0]} of the run lies on a track of the file too, and became part of it."
    return f"Tracks {', '.join(names[:most])}{more} of the run lie on tracks of the file too, and became part of them."


def _same(track: Track, shown: Track, found: Match, old: TrackDoc) -> bool:
    """Whether a track of the run shows already what the file says, and has its notes, as far as a file can say it."""
    judged = track.state in REVIEWS and track.state not in ("open", shown.state)
    new = new_notes(track.notes, "", old) or (is_ignored(track) and not old.ignore)
    return not judged and not new and as_shown(track, found)


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
            "attributes": {**document.attributes, **old.attributes, **track.attributes},
            "ignore": old.ignore or is_ignored(track),
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
