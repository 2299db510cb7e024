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
from app.exchange.engine_tracks import EngineTrackInfo, engine_label
from app.exchange.joined_tracks import join_tracks
from app.exchange.marks import REVIEWS, is_ignored, new_notes
from app.exchange.merge_import import Match, key_frames_of, match, merge_import, shows_same, whole_label
from app.exchange.same_sign import also_covered, boxes_touch, match_by_overlap
from tsr_engine.exchange.dataset import Skipped, Track
from tsr_engine.exchange.filters import select_frames
from tsr_engine.plural import plural

THIN_PX = 0.5
"""Maximum move of an edge, px, when a track with a box in every frame is thinned to key frames."""


@dataclass(slots=True)
class AnnotationResult:
    """Result of converting the tracks.

    Attributes:
        documents: documents to store, by key.
        changed: tracks of the run that change.
        made: new tracks.
        same: tracks of the run that already show the same.
        merged: names of the run's tracks that are merged into another, because the file has both as one.
        boxes: number of boxes of the changed and the new tracks.
        repaired: repairs, one sentence each.
        skipped: what an annotation cannot hold.
    """

    documents: dict[str, TrackDoc] = field(default_factory=dict)
    changed: int = 0
    made: int = 0
    same: int = 0
    merged: list[str] = field(default_factory=list)
    boxes: int = 0
    repaired: list[str] = field(default_factory=list)
    skipped: list[Skipped] = field(default_factory=list)

    def report_covered(
        self, merged: Iterable[str], remaining: Iterable[str], document: TrackDoc, present: Mapping[str, TrackDoc]
    ) -> None:
        """Report the run's tracks that a track of the file covers besides its own."""
        self.merged += [track_name(name, present.get(name)) for name in merged]
        for name in remaining:
            reason = (
                f"It lies on track {track_name(document.key, document)} of the file, but people have corrected it, "
                "so it stays. Merge the two, or reject one."
            )
            self.skipped.append(Skipped(f"track {track_name(name, present.get(name))} of the run", reason))


def annotate(
    tracks: Iterable[Track],
    shown: Mapping[str, Track],
    present: Mapping[str, TrackDoc],
    author: str,
    size: tuple[int, int],
    exported: bool = False,
    engine: Mapping[int, EngineTrackInfo] = MappingProxyType({}),
) -> AnnotationResult:
    """Make the documents with which a run shows tracks.

    Args:
        tracks: tracks of the file.
        shown: the run's current tracks, by name.
        present: the run's documents, by key.
        author: author of notes.
        size: width and height of the picture, px; imports are cut at its edges.
        exported: the file is an export of this run, so match tracks by name only.
        engine: the engine's tracks by number; at least those with a document.
    """
    result = AnnotationResult()
    thinned = 0
    kept_tracks, ignored = _without_ignored(tracks)
    names = _matching_names(kept_tracks, shown, present, exported)
    covered = also_covered(kept_tracks, names, shown)
    labels = {number: info.label for number, info in engine.items()}
    for index, (track, name) in enumerate(zip(kept_tracks, names, strict=True)):
        is_known = name is not None
        key = f"h{uuid4().hex[:16]}" if name is None else name
        documents = {name: _untouched_document(name, present, engine, shown) for name in covered.get(index, [])}
        untouched = {name: doc for name, doc in documents.items() if doc is not None}
        base, run = _base_document(name, shown, present), shown.get(key)
        if base is not None and run is not None:
            base, run = join_tracks(base, run, ((doc, shown[name]) for name, doc in untouched.items()))
        matched = None if base is None or run is None else match(track, run, base, size, THIN_PX)
        old = present.get(key, TrackDoc(key=key))
        if run is not None and matched is not None and not untouched and _is_unchanged(track, run, matched, old):
            result.same += 1
            continue
        if base is None or matched is None or matched.run is None:
            document, is_thinned = _new_document(key, track, engine_label(old, labels))
        else:
            own_label = shown[key].label if base.class_id is None else engine_label(base, labels)
            document, is_thinned = merge_import(track, matched, base, own_label, THIN_PX)
        document = _with_track_values(document, track, old, author)
        if key in present and present[key].has_same_content(document) and not untouched:  # imported before
            result.same += 1
            continue
        result.documents[key] = document
        result.documents |= {n: d.model_copy(update={"gone": True, "merged_into": key}) for n, d in untouched.items()}
        result.report_covered(untouched, [name for name, doc in documents.items() if doc is None], document, present)
        thinned += is_thinned
        result.boxes += len(track.frames)
        result.changed += is_known
        result.made += not is_known
    if result.merged:
        result.repaired.append(_merged_message(result.merged))
    if thinned:
        many = "tracks with a box of their own in every frame were"
        dense_ones = plural(thinned, "track with a box of its own in every frame was", many)
        result.repaired.append(f"{dense_ones} thinned to key frames; no edge moves by more than {THIN_PX} px.")
    if ignored:
        boxes = plural(ignored, "box that is to be ignored", "boxes that are to be ignored")
        result.skipped.append(Skipped(boxes, "An annotation has no such regions."))
    return result


def _without_ignored(tracks: Iterable[Track]) -> tuple[list[Track], int]:
    """The tracks without boxes to ignore, and the number of these boxes."""
    kept: list[Track] = []
    ignored = 0
    for track in tracks:
        part: Track | None = track
        if track.ignore is not None and track.ignore.any() and not is_ignored(track):
            ignored += int(track.ignore.sum())
            part = select_frames(replace(track, ignore=None), ~track.ignore)
        if part is not None:
            kept.append(part)
    return kept, ignored


def _matching_names(
    tracks: list[Track], shown: Mapping[str, Track], present: Mapping[str, TrackDoc], exported: bool
) -> list[str | None]:
    """The run's track for each track, by name or else by overlap; None: it is new."""
    names: list[str | None] = []
    used: set[str] = set()
    for track in tracks:
        is_known = track.uid in shown or track.uid in present
        if is_known and not exported:
            is_known = track.uid in shown and boxes_touch(track, shown[track.uid])
        match = track.uid if is_known and track.uid not in used else None
        names.append(match)
        used |= set() if match is None else {match}
    unmatched = [i for i, name in enumerate(names) if name is None]
    remaining = {name: track for name, track in shown.items() if name not in used and track.state != "rejected"}
    for index, name in match_by_overlap([tracks[i] for i in unmatched], remaining).items():
        names[unmatched[index]] = name
    return names


def _untouched_document(
    name: str, present: Mapping[str, TrackDoc], engine: Mapping[int, EngineTrackInfo], shown: Mapping[str, Track]
) -> TrackDoc | None:
    """The document of an untouched engine track; None: it has corrections."""
    if name not in present:
        return _engine_document(name, shown) if name.startswith("m") else None
    info = engine.get(int(name[1:])) if name.startswith("m") else None
    return present[name] if present[name].untouched(None if info is None else info.span) else None


def _merged_message(names: list[str]) -> str:
    """A sentence about the run's tracks that are merged into others."""
    max_names = 5
    more = f" and {len(names) - max_names} more" if len(names) > max_names else ""
    if len(names) == 1:
        return f"Track {names[0]} of the run also lies on a track of the file and was merged into it."
    first_names = ", ".join(names[:max_names])
    return f"Tracks {first_names}{more} of the run also lie on tracks of the file and were merged into them."


def _is_unchanged(track: Track, shown: Track, matched: Match, old: TrackDoc) -> bool:
    """Whether a track of the run already shows what the file says, notes included, as far as a file can hold it."""
    judged = track.state in REVIEWS and track.state not in ("open", shown.state)
    new = new_notes(track.notes, "", old) or (is_ignored(track) and not old.ignore)
    return not judged and not new and shows_same(track, matched)


def _new_document(key: str, track: Track, engine: int | None) -> tuple[TrackDoc, bool]:
    """A document that shows the track with key frames only, and whether boxes were thinned.

    ``engine`` is the engine's class of the track with that key, which is no correction; None: a person's track.
    """
    keys, thinned = key_frames_of(track, THIN_PX, track.label)
    label = whole_label(track)
    return TrackDoc(key=key, class_id=None if label == engine else label, keys=keys), thinned


def _with_track_values(document: TrackDoc, track: Track, old: TrackDoc, author: str) -> TrackDoc:
    """The document with the file's values of the whole track; values that the file lacks stay."""
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


def _base_document(name: str | None, shown: Mapping[str, Track], present: Mapping[str, TrackDoc]) -> TrackDoc | None:
    """The document of a displayed track of the run; None: there is none."""
    if name is None or name not in shown:
        return None
    return present[name] if name in present else _engine_document(name, shown)


def _engine_document(name: str, shown: Mapping[str, Track]) -> TrackDoc:
    frames = shown[name].frames
    return engine_doc(int(name[1:]), int(frames[0]), int(frames[-1]))
