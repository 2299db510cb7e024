"""Converts a person's corrections to expectations of the engine's output.

====================================  ==================================================================
correction                            expectation
====================================  ==================================================================
a track of their own (nothing there)  ``found``
another label for the whole track     ``label``; nothing if the model lacks the label or it is not in the set,
                                      because the engine cannot give it
key frames with boxes                 ``boxes`` in those frames
a region to ignore                    nothing
not a sign, rejected, deleted         ``absent``; a second track on a sign that stays: that sign is ``one``
deleted from some frame on            ``absent`` in the deleted frames
pieces of several tracks in one       ``one``
pieces of one track in several        ``apart``
accepted                              ``found``; and the current ``label``, unless the track continues after
                                      the last frame: some of its votes are missing then, so its class may
                                      differ although nobody saw a bug
====================================  ==================================================================
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from app.edits.documents import TrackDoc
from app.edits.effective import Effective, box_at
from app.exchange.engine_tracks import EngineTrack, EngineTracks
from tsr_engine.bundle import Bounds, Expectation, Expected, ExpectedSign
from tsr_engine.evidence import EvidenceReader
from tsr_engine.geometry.boxes import iou
from tsr_engine.labels.classes import RunClasses, classes_of_keys
from tsr_engine.labels.files import DEFAULT, shipped_set

Edges = tuple[float, float, float, float]


def expectation_of(
    reader: EvidenceReader,
    documents: Mapping[str, TrackDoc],
    first: int,
    stop: int,
    keys: Collection[str] = (),
    bounds: Bounds | None = None,
    classes: RunClasses | None = None,
) -> Expectation:
    """Build the expectation for the frames ``first <= k < stop``.

    Args:
        reader: the run.
        documents: of the corrected tracks, by key.
        first: first frame.
        stop: frame after the last.
        keys: use only the corrections of these tracks; empty: of all.
        bounds: tolerances of a match; unset: the defaults.
        classes: maps the run's class numbers to the label set of the documents; unset: to ``gtsrb-43``.
    """
    labels = reader.header.labels
    if classes is None:
        classes = classes_of_keys(labels, shipped_set(DEFAULT))
    present = [f"m{track.track_id}" for track in reader.tracks(first, stop) if track.confirmed]
    tolerances = Bounds() if bounds is None else bounds
    builder = _ExpectationBuilder(EngineTracks(reader), classes, documents, present, first, stop, tolerances)
    for key in sorted(documents):
        if not keys or key in keys:
            builder.add(documents[key])
    builder.expect_separate(set(keys))
    return Expectation(bounds=builder.bounds, signs=builder.signs, expected=builder.expected, labels=list(labels or ()))


@dataclass(slots=True)
class _ExpectationBuilder:
    engine_tracks: EngineTracks
    classes: RunClasses
    documents: Mapping[str, TrackDoc]
    present: list[str]
    """Keys of the engine's tracks in the frames."""
    first: int
    stop: int
    bounds: Bounds
    signs: dict[str, ExpectedSign] = field(default_factory=dict)
    expected: list[Expected] = field(default_factory=list)
    _tracks: dict[int, EngineTrack | None] = field(default_factory=dict)

    def add(self, doc: TrackDoc) -> None:
        """Add the expectations of one document."""
        if doc.merged_into is not None or doc.ignore:
            return  # the document that it was merged into covers it
        if doc.is_no_sign():
            self._absent(doc.key, self._engine_boxes(doc))
            return
        shown = self._shown(doc)
        if doc.key.startswith("m"):
            self._absent(f"{doc.key} cut", self._removed_boxes(doc))
        if not shown:
            return
        self._add_sign(doc.key, shown)
        pieces = self._pieces(doc)
        drawn_frames = [f for f in shown if (key := doc.keys.get(str(f))) is not None and key.box is not None]
        accepted = doc.review == "accepted"
        if not pieces or accepted:
            self._expect(doc.key, "found")
        number = None if doc.class_id is None else self.classes.to_class(doc.class_id)
        if doc.class_id is None and accepted and not self._continues(doc):
            number = self._class_number(doc)
        if number is not None:
            self.expected.append(Expected(id=f"{doc.key}.label", kind="label", sign=doc.key, class_id=number))
        hidden = set(self.signs[doc.key].hidden)
        if pieces and (visible := [f for f in drawn_frames if f not in hidden]):
            self.expected.append(Expected(id=f"{doc.key}.boxes", kind="boxes", sign=doc.key, frames=visible))
        if len(pieces) > 1:
            self._expect(doc.key, "one")

    def expect_separate(self, keys: set[str]) -> None:
        """Expect pairs of signs that the engine has joined to be separate."""
        holders: dict[int, list[str]] = {}
        for key in sorted(self.documents):
            doc = self.documents[key]
            if doc.is_no_sign():
                continue
            for track in sorted(self._pieces(doc)):
                holders.setdefault(track, []).append(key)
        pairs = {pair for keys in holders.values() for pair in combinations(keys, 2)}
        for a, b in sorted(pairs):
            if keys and not {a, b} & keys:
                continue
            for key in (a, b):
                if key not in self.signs and (shown := self._shown(self.documents[key])):
                    self._add_sign(key, shown)
            if a in self.signs and b in self.signs:
                self.expected.append(Expected(id=f"{a}.apart.{b}", kind="apart", sign=a, other=b))

    def _pieces(self, doc: TrackDoc) -> set[int]:
        """The engine's tracks with a segment in the frames."""
        return {piece.track for piece in doc.segments if piece.first < self.stop and piece.last >= self.first}

    def _expect(self, key: str, kind: str) -> None:
        name = f"{key}.{kind}"
        if all(expected.id != name for expected in self.expected):
            self.expected.append(Expected.model_validate({"id": name, "kind": kind, "sign": key}))

    def _add_sign(self, key: str, shown: Mapping[int, Effective]) -> None:
        frames = sorted(shown)
        self.signs[key] = ExpectedSign(
            frames=frames, boxes=[shown[f].box for f in frames], hidden=[f for f in frames if shown[f].occluded]
        )

    def _absent(self, key: str, boxes: Mapping[int, Edges]) -> None:
        """Expect no boxes here, except on signs that stay."""
        if not boxes:
            return
        overlapping_signs = {f: sign for f, box in boxes.items() if (sign := self._sign_at(f, box)) is not None}
        if 2 * len(overlapping_signs) >= len(boxes):
            sign = max(sorted(set(overlapping_signs.values())), key=list(overlapping_signs.values()).count)
            if sign not in self.signs:
                self._add_sign(sign, self._shown_as(sign))
            self._expect(sign, "one")
            return
        frames = sorted(boxes.keys() - overlapping_signs.keys())
        self.signs[key] = ExpectedSign(frames=frames, boxes=[boxes[f] for f in frames])
        self.expected.append(Expected(id=f"{key}.absent", kind="absent", sign=key))

    def _sign_at(self, frame: int, box: Edges) -> str | None:
        """Return the key of a sign that stays and overlaps a box."""
        for key in self._remaining_keys():
            found = self._box_of(key, frame)
            if found is not None and float(iou(box, found.box)[0, 0]) >= self.bounds.iou:
                return key
        return None

    def _remaining_keys(self) -> Iterator[str]:
        yield from (key for key, doc in sorted(self.documents.items()) if not doc.is_no_sign())
        yield from (key for key in self.present if key not in self.documents)

    def _shown_as(self, key: str) -> dict[int, Effective]:
        return {f: box for f in range(self.first, self.stop) if (box := self._box_of(key, f)) is not None}

    def _shown(self, doc: TrackDoc) -> dict[int, Effective]:
        return {f: b for f in range(self.first, self.stop) if (b := box_at(doc, f, self._engine_box)) is not None}

    def _box_of(self, key: str, frame: int) -> Effective | None:
        doc = self.documents.get(key)
        if doc is not None:
            return box_at(doc, frame, self._engine_box)
        box = self._engine_box(int(key[1:]), frame)
        return None if box is None else Effective(box, "engine", False, None)

    def _engine_boxes(self, doc: TrackDoc) -> dict[int, Edges]:
        """The engine's boxes of a track that is no sign; none for a track that a person drew."""
        boxes: dict[int, Edges] = {}
        for track in sorted(set(doc.engine_tracks())):
            for frame in range(self.first, self.stop):
                inside = doc.gone or any(p.track == track and p.first <= frame <= p.last for p in doc.segments)
                is_elsewhere = doc.gone and self._is_in_other_document(doc.key, track, frame)
                box = self._engine_box(track, frame) if inside and not is_elsewhere else None
                if box is not None:
                    boxes.setdefault(frame, box)
        return boxes

    def _removed_boxes(self, doc: TrackDoc) -> dict[int, Edges]:
        """The engine's boxes of a track in frames that no document shows."""
        track = int(doc.key[1:])
        boxes: dict[int, Edges] = {}
        for frame in range(self.first, self.stop):
            box = self._engine_box(track, frame)
            shown = box_at(doc, frame, self._engine_box)
            if box is not None and shown is None and not self._is_in_other_document(doc.key, track, frame):
                boxes[frame] = box
        return boxes

    def _is_in_other_document(self, key: str, track: int, frame: int) -> bool:
        """Whether another document contains this frame of an engine track."""
        return any(
            other.key != key and any(p.track == track and p.first <= frame <= p.last for p in other.segments)
            for other in self.documents.values()
        )

    def _engine_box(self, track: int, frame: int) -> Edges | None:
        engine_track = self._track(track)
        if engine_track is None:
            return None
        index = int(np.searchsorted(engine_track.frames, frame))
        if index == len(engine_track.frames) or engine_track.frames[index] != frame:
            return None
        x1, y1, x2, y2 = engine_track.boxes[index].tolist()
        return x1, y1, x2, y2

    def _track(self, number: int) -> EngineTrack | None:
        if number not in self._tracks:
            self._tracks[number] = self.engine_tracks.track(number)
        return self._tracks[number]

    def _continues(self, doc: TrackDoc) -> bool:
        """Whether the engine has boxes of the track after the last frame."""
        later = ((piece, self._track(piece.track)) for piece in doc.segments if piece.last >= self.stop)
        return any(found is not None and int(found.frames[-1]) >= self.stop for _, found in later)

    def _class_number(self, doc: TrackDoc) -> int | None:
        """The engine's class of the track."""
        labels = (self.engine_tracks.labels.get(number, -1) for number in doc.engine_tracks())
        return next((label for label in labels if label >= 0), None)
