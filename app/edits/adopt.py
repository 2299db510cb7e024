"""Carry edits over to another run of the same video: each track kept, no longer needed, or a conflict. Pure.

A track of the old run matches the track of the new one that overlaps it (``MIN_MATCH_IOU``) in the most frames, if
those are at least half of the frames of the shorter of the two. An edit is no longer needed if the new run shows the
wanted result by itself: the same frames but for one in ten, in each corrected frame a box within ``MIN_CORRECTED_IOU``,
and the same label. A verdict is kept only if nine of ten frames agree within ``MIN_AGREEMENT_IOU`` and the label is the
same. If an accepted track is not needed, only its verdict is kept.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from app.edits.documents import OPEN_END, Segment, TrackDoc, engine_doc
from app.edits.effective import AS_ENGINE, EffectiveTrack, effective_track
from tsr_engine.geometry.boxes import iou_each

MIN_MATCH_IOU = 0.5
MIN_AGREEMENT_IOU = 0.7
MIN_CORRECTED_IOU = 0.8

Ints = NDArray[np.int64]
Boxes = NDArray[np.float64]


class EngineRun:
    """The engine's tracks of one run.

    Args:
        frame: shape (n,), ascending within each track.
        track: shape (n,), the engine's number of the track.
        boxes: shape (n, 4).
        class_id: shape (n,), -1: unknown.
    """

    def __init__(self, frame: Ints, track: Ints, boxes: Boxes, class_id: Ints) -> None:
        order = np.lexsort((frame, track))
        self._frame, self._boxes = frame[order], boxes[order]
        ids, starts = np.unique(track[order], return_index=True)
        stops = [*starts[1:].tolist(), len(order)]
        self._rows = {int(i): slice(int(a), int(b)) for i, a, b in zip(ids, starts, stops, strict=True)}
        self.label = {i: int(class_id[order][rows.start]) for i, rows in self._rows.items()}

    def ids(self) -> list[int]:
        """All tracks."""
        return list(self._rows)

    def of(self, track: int) -> tuple[Ints, Boxes]:
        """Frames and boxes of a track; empty if there is no such track."""
        rows = self._rows.get(track, slice(0, 0))
        return self._frame[rows], self._boxes[rows]

    def span_of(self, key: str) -> tuple[int, int] | None:
        """First and last frame of a track by its key; None: it is no track of the engine."""
        known = key.startswith("m") and int(key[1:]) in self.label
        return self.span(int(key[1:])) if known else None

    def span(self, track: int) -> tuple[int, int]:
        """First and last frame of an existing track."""
        frames = self.of(track)[0]
        return int(frames[0]), int(frames[-1])


@dataclass
class Adoption:
    """The result of carrying edits over."""

    changed: dict[str, dict[str, TrackDoc]] = field(default_factory=dict)
    """Key in the old run -> its documents in the new run."""
    kept: list[str] = field(default_factory=list)
    """Keys in the new run."""
    not_needed: list[str] = field(default_factory=list)
    """Keys in the old run."""
    conflicts: list[tuple[str, str, int]] = field(default_factory=list)
    """Key in the old run, reason, frame."""


def adopt_documents(
    docs: Mapping[str, TrackDoc], old: EngineRun, new: EngineRun, present: Mapping[str, TrackDoc], frames: int
) -> Adoption:
    """Decide for every edited track whether it is kept, no longer needed, or a conflict.

    Args:
        docs: the old run's documents.
        old: the engine's tracks of the old run.
        new: the engine's tracks of the new run.
        present: documents of the new run; those with edits are not changed.
        frames: number of frames of the video.
    """
    adopter = _Adopter(docs, old, new, present, frames)
    for key, doc in sorted(docs.items()):
        if doc.merged_into is not None:
            continue  # handled with the track that it was merged into
        if doc.gone:
            adopter.adopt_deleted(key, doc)
        else:
            adopter.adopt_existing(key, doc)
    return adopter.result


class _Adopter:
    """Carries edits over, track by track; for the arguments see :func:`adopt_documents`."""

    def __init__(
        self,
        docs: Mapping[str, TrackDoc],
        old: EngineRun,
        new: EngineRun,
        present: Mapping[str, TrackDoc],
        frames: int,
    ) -> None:
        self.result = Adoption()
        self._old, self._new, self._present, self._frames = old, new, present, frames
        tracks = {s.track for doc in docs.values() for s in doc.segments}
        self._matches = {track: _matching_track(old.of(track), new) for track in tracks}
        self._edited = {key for key, doc in present.items() if not doc.untouched(new.span_of(key))}

    def adopt_deleted(self, key: str, doc: TrackDoc) -> None:
        """Delete the track that matches a deleted one, unless it has edits."""
        match = self._matches.get(int(key[1:])) if key.startswith("m") else None
        name = f"m{match}"
        if match is None or (name in self._present and self._present[name].gone):
            self.result.not_needed.append(key)
        elif name in self._edited:
            reason = f"It was deleted, but its track {name} in this run carries edits."
            self._conflict(key, reason, self._new.span(match)[0])
        else:
            self._keep(key, name, {name: TrackDoc(key=name, segments=(_full_segment(match, self._new),), gone=True)})

    def adopt_existing(self, key: str, doc: TrackDoc) -> None:
        """Carry the document of a track over that is not deleted."""
        last = doc.last_named_frame()
        if last is not None and last >= self._frames:  # stored by a version without this check
            reason = f"It is about frame {last}, and the video ends at {self._frames - 1}. Draw it, or leave it out."
            return self._conflict(key, reason, self._frames - 1)
        wanted = effective_track(doc, self._old.of, self._frames)
        start = int(wanted.frame[0]) if len(wanted.frame) else 0
        label = _label(doc, self._old)
        has_values = any(key.attributes for key in doc.keys.values()) or doc.attributes or doc.ignore
        is_plain = not doc.notes and not doc.not_a_sign and not has_values and not wanted.occluded.any()
        candidates = {t for t in self._matches.values() if t is not None} if doc.segments else self._new.ids()
        for candidate in candidates:
            if is_plain and doc.review in ("open", "accepted") and _shows_same(self._new, candidate, wanted, label):
                if doc.review == "accepted":
                    return self._adopt_verdict(key, candidate, start)
                return self.result.not_needed.append(key)
        segments: list[Segment] = []
        for segment in doc.segments:
            match = self._matches[segment.track]
            if match is None:
                reason = "The engine no longer finds this track. Draw it, or leave it out."
                return self._conflict(key, reason, segment.first)
            moved = _move_segment(segment, self._old, self._new, match)
            if moved is not None:
                segments.append(moved)
        if not segments and not any(k.box is not None for k in doc.keys.values()):
            return self._conflict(key, "Nothing of this part of the track is left in this run.", start)
        own_match = self._matches.get(int(key[1:])) if key.startswith("m") and segments else None
        name = key if own_match is None else f"m{own_match}"
        others = sorted({f"m{s.track}" for s in segments} - {name}) if key.startswith("m") else []
        conflict = next((n for n in (name, *others) if n in self._edited), None)
        if conflict is not None:
            return self._conflict(key, _conflict_reason(conflict), start)
        ordered = sorted(segments, key=lambda s: (s.first, s.track))
        if any(a.last >= b.first for a, b in pairwise(ordered)):
            return self._conflict(key, "Its pieces lie in the same frames in this run. Merge them by hand.", start)
        moved_doc = doc.model_copy(update={"key": name, "revision": 0, "segments": tuple(ordered)})
        shown = effective_track(moved_doc, self._new.of, self._frames)
        is_judged = doc.review in ("accepted", "rejected")
        if is_judged and not (_agreement(wanted, shown) >= 0.9 and label == _label(moved_doc, self._new)):
            moved_doc = moved_doc.model_copy(update={"review": "open"})
        documents = {name: moved_doc}
        for other in others:
            segment = _full_segment(int(other[1:]), self._new)
            documents[other] = TrackDoc(key=other, segments=(segment,), gone=True, merged_into=name)
        return self._keep(key, name, documents)

    def _adopt_verdict(self, key: str, track: int, start: int) -> None:
        """The new run shows an accepted track by itself: accept its track unless that has edits."""
        name = f"m{track}"
        if name not in self._edited:
            accepted = engine_doc(track, *self._new.span(track)).model_copy(update={"review": "accepted"})
            self._keep(key, name, {name: accepted})
        elif name in self._present and self._present[name].review == "accepted":
            self.result.not_needed.append(key)
        else:
            self._conflict(key, _conflict_reason(name), start)

    def _keep(self, key: str, name: str, documents: dict[str, TrackDoc]) -> None:
        self._edited.update(documents)
        self.result.changed[key] = documents
        self.result.kept.append(name)

    def _conflict(self, key: str, reason: str, frame: int) -> None:
        self.result.conflicts.append((key, reason, frame))


def _conflict_reason(name: str) -> str:
    return f"Track {name} of this run carries other edits already."


def _matching_track(track: tuple[Ints, Boxes], run: EngineRun) -> int | None:
    """The track of a run that matches a track; None: there is none."""
    best, max_hits = None, 0
    for candidate in run.ids():
        other = run.of(candidate)
        common = _overlaps(track, other)
        hits = int((common >= MIN_MATCH_IOU).sum())
        if hits > max_hits and hits >= 0.5 * min(len(track[0]), len(other[0])):
            best, max_hits = candidate, hits
    return best


def _overlaps(a: tuple[Ints, Boxes], b: tuple[Ints, Boxes]) -> Boxes:
    """IoU in each common frame, shape (m,)."""
    if not len(a[0]) or not len(b[0]) or a[0][-1] < b[0][0] or b[0][-1] < a[0][0]:
        return np.zeros(0)
    _, i, j = np.intersect1d(a[0], b[0], assume_unique=True, return_indices=True)
    return iou_each(a[1][i], b[1][j])


def _agreement(wanted: EffectiveTrack, shown: EffectiveTrack) -> float:
    """Share of the frames of either in which both agree."""
    either = len(np.union1d(wanted.frame, shown.frame))
    hits = int((_overlaps((wanted.frame, wanted.boxes), (shown.frame, shown.boxes)) >= MIN_AGREEMENT_IOU).sum())
    return hits / either if either else 1.0


def _shows_same(new: EngineRun, track: int, wanted: EffectiveTrack, label: int) -> bool:
    """Whether a track of the new run already equals the edited track."""
    frames, boxes = new.of(track)
    if new.label.get(track, -1) != label or not len(frames):
        return False
    both, i, _ = np.intersect1d(wanted.frame, frames, assume_unique=True, return_indices=True)
    if len(both) < 0.9 * len(np.union1d(wanted.frame, frames)):
        return False
    corrected = wanted.origin != 0
    person = (wanted.frame[corrected], wanted.boxes[corrected])
    close = _overlaps(person, (frames, boxes))
    whole = _overlaps((wanted.frame, wanted.boxes), (frames, boxes))
    labels = wanted.class_id[i]
    same = bool(((labels == AS_ENGINE) | (labels == label)).all())
    return (
        same
        and len(close) == int(corrected.sum())
        and bool((close >= MIN_CORRECTED_IOU).all())
        and bool((whole >= MIN_MATCH_IOU).all())
    )


def _full_segment(track: int, run: EngineRun) -> Segment:
    first, last = run.span(track)
    return Segment(track=track, first=first, last=last)


def _move_segment(segment: Segment, old: EngineRun, new: EngineRun, match: int) -> Segment | None:
    """The segment on the new track; None: empty. A cut stays, an end of the old track becomes that of the new one."""
    (first, last), (begin, end) = old.span(segment.track), new.span(match)
    low = begin if segment.first <= first else max(begin, segment.first)
    high = end if segment.last >= min(last, OPEN_END) else min(end, segment.last)
    return Segment(track=match, first=low, last=high) if low <= high else None


def _label(doc: TrackDoc, run: EngineRun) -> int:
    """The label of a document; -1: unknown, or none of the classes."""
    if doc.class_id is not None:
        return doc.class_id
    track = doc.original_track()
    return -1 if track is None else run.label.get(track, -1)
