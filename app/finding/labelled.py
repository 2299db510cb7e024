"""Finds the videos that have a track of a label, with an answer to an attribute, or in a state of review.

A video stands with the run that it is opened with, as people have left its tracks. What the engine calls a track lies
in the evidence of its run; a copy in the database makes thousands of videos answer at once, and is made when somebody
asks.
"""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Text, cast, select
from sqlalchemy.orm import Session

from app.edits.documents import NO_CLASS
from app.errors import ApiError, Invalid
from app.evidence.service import EvidenceService
from app.labels.mapping import reported_classes
from app.labels.store import default_key, newest
from app.shapes import Model
from app.storage.database import Database
from app.storage.latest import latest_last
from app.storage.models import Run, TrackClasses, TrackDocument, Video
from tsr_engine.errors import TsrError
from tsr_engine.labels.matching import LabelFinder
from tsr_engine.labels.model import Label, LabelSet

__all__ = ["LabelledVideos", "Matches", "State", "Wanted"]

State = Literal["open", "needs_work", "accepted", "rejected", "ignored"]
_BUDGET_S: Final = 1.5
"""Longest time that one question spends on copying evidence."""
_AT_ONCE: Final = 500
"""Runs of one query."""
Pairs = NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class Wanted:
    """What one and the same track must have.

    Attributes:
        label: key, name or alias of a label; ``-1``: not in the set; None: any.
        attribute: name of an attribute; None: any.
        value: an answer to it, as text; None: any that a person has given.
        state: its state of review; None: any.
    """

    label: str | None = None
    attribute: str | None = None
    value: str | None = None
    state: State | None = None


class Matches(Model):
    """Videos with such tracks.

    Attributes:
        videos: id of the video -> how many of its tracks.
        left: videos that are not counted yet; ask again.
        unreadable: videos whose tracks cannot be read here.
    """

    videos: dict[str, int]
    left: int
    unreadable: int


@dataclass(frozen=True, slots=True)
class _Stands:
    """A video with the run that it is opened with."""

    video: str
    run: str
    reported: Mapping[str, Any] | None
    labels: LabelSet


class LabelledVideos:
    """Answers for the library; thread-safe."""

    def __init__(self, database: Database, evidence: EvidenceService) -> None:
        self._database = database
        self._evidence = evidence
        self._unreadable: set[str] = set()

    def find(self, wanted: Wanted, budget: float = _BUDGET_S) -> Matches:
        """Find videos.

        Args:
            wanted: what a track must have.
            budget: longest time spent on runs that nobody has asked about before, s.

        Raises:
            Invalid: no label set in use has such a label.
        """
        with self._database.read() as session:
            stands = _standing(session)
            ids = _label_ids(session, wanted.label, stands)
            pairs = {run: np.frombuffer(rows, "<i4").reshape(-1, 2) for run, rows in _copies(session, stands)}
        left = self._copy([each.run for each in stands if each.run not in pairs], pairs, budget)
        counts: Counter[str] = Counter()
        with self._database.read() as session:
            for each, touched in _documents(session, stands, wanted.attribute):
                if each.run in pairs:
                    track_of = _Tracks(each, pairs[each.run], None if ids is None else ids[each.labels.key])
                    counts[each.video] += track_of.count(touched, wanted)
        unreadable = sum(each.run in self._unreadable for each in stands)
        return Matches(videos={video: n for video, n in counts.items() if n}, left=left, unreadable=unreadable)

    def _copy(self, runs: list[str], pairs: dict[str, Pairs], budget: float) -> int:
        """Copy what evidence says of runs into the database, as far as the time goes; how many are left."""
        ends, made = time.monotonic() + budget, dict[str, Pairs]()
        todo = [run for run in runs if run not in self._unreadable]
        left = len(todo)
        for run in todo:
            if time.monotonic() > ends:
                break
            left -= 1
            try:
                made[run] = np.array(self._evidence.track_classes(run), "<i4").reshape(-1, 2)
            except (ApiError, TsrError):
                self._unreadable.add(run)
        if made:
            with self._database.write() as session:
                there = set(session.scalars(select(Run.id).where(Run.id.in_(made))))
                known = set(session.scalars(select(TrackClasses.run_id).where(TrackClasses.run_id.in_(made))))
                session.add_all(TrackClasses(run_id=run, rows=made[run].tobytes()) for run in there - known)
        pairs.update(made)
        return left


def _standing(session: Session) -> list[_Stands]:
    """The complete run that each video is opened with."""
    usual = default_key(session)
    columns = (Run.video_id, Run.id, Run.state, Run.labels, Video.label_set)
    runs = select(*columns).join(Video, Video.id == Run.video_id).where(Run.kind != "whatif").order_by(*latest_last())
    latest = {row.video_id: row for row in session.execute(runs)}
    sets = {key: newest(session, key) for key in {row.label_set or usual for row in latest.values()}}
    return [
        _Stands(row.video_id, row.id, row.labels, sets[row.label_set or usual])
        for row in latest.values()
        if row.state == "complete"
    ]


def _label_ids(session: Session, word: str | None, stands: list[_Stands]) -> dict[str, int] | None:
    """The id that a label has in each set, ``NO_CLASS - 1``: it has none; None: any label will do."""
    if word is None:
        return None
    sets = {each.labels.key: each.labels for each in stands}
    usual = default_key(session)
    sets.setdefault(usual, newest(session, usual))
    if word == str(NO_CLASS):
        return dict.fromkeys(sets, NO_CLASS)
    found = {key: LabelFinder(labels).named(word) for key, labels in sets.items()}
    if not any(found.values()):
        raise Invalid(f"No label set in use has a label called {word[:80]!r}.", field="label", code="no_such_label")
    return {key: NO_CLASS - 1 if match is None else match.label.id for key, match in found.items()}


def _copies(session: Session, stands: list[_Stands]) -> Iterator[tuple[str, bytes]]:
    for start in range(0, len(stands), _AT_ONCE):
        runs = [each.run for each in stands[start : start + _AT_ONCE]]
        rows = select(TrackClasses.run_id, TrackClasses.rows).where(TrackClasses.run_id.in_(runs))
        yield from session.execute(rows)


@dataclass(frozen=True, slots=True)
class _Touched:
    """What a person has made of a track."""

    key: str
    label: int | None
    gone: bool
    state: State
    track: int | None
    """Number of the engine's track that it began as."""
    answers: Mapping[str, Any]
    """Attributes of the whole track."""
    changing: list[Mapping[str, Any]]
    """Those from single frames on."""


def _documents(
    session: Session, stands: list[_Stands], attribute: str | None
) -> Iterator[tuple[_Stands, list[_Touched]]]:
    """Each video with the tracks that people have touched; attributes are read where one is asked for."""
    stored = TrackDocument.document
    columns = (
        TrackDocument.run_id,
        TrackDocument.key,
        stored["class_id"].as_integer(),
        stored["gone"].as_boolean(),
        stored["review"].as_string(),
        stored["not_a_sign"].as_boolean(),
        stored["ignore"].as_boolean(),
        stored[("segments", 0, "track")].as_integer(),
    )
    quoted = json.dumps(attribute)
    for start in range(0, len(stands), _AT_ONCE):
        part = stands[start : start + _AT_ONCE]
        here = TrackDocument.run_id.in_([each.run for each in part])
        answers: dict[tuple[str, str], Any] = {}
        if attribute is not None:
            saying = cast(stored, Text).contains(quoted, autoescape=True)
            for run, key, document in session.execute(
                select(TrackDocument.run_id, TrackDocument.key, stored).where(here, saying)
            ):
                answers[run, key] = document
        touched: dict[str, list[_Touched]] = {each.run: [] for each in part}
        for run, key, label, gone, review, no_sign, ignore, track in session.execute(select(*columns).where(here)):
            document = answers.get((run, key), {})
            state: State = "ignored" if ignore else "rejected" if no_sign else review or "open"
            changing = [each.get("attributes") or {} for each in (document.get("keys") or {}).values()]
            whole = document.get("attributes") or {}
            touched[run].append(_Touched(key, label, bool(gone), state, track, whole, changing))
        for each in part:
            yield each, touched[each.run]


class _Tracks:
    """The tracks of one video."""

    def __init__(self, stands: _Stands, pairs: Pairs, wanted: int | None) -> None:
        """Take the engine's tracks, and the id of the label that is wanted; None: any."""
        self._labels = stands.labels
        self._numbers = pairs[:, 0]
        self._of = reported_classes(stands.reported, stands.labels).to_labels(pairs[:, 1].astype(np.int64))
        self._wanted = wanted

    def count(self, touched: list[_Touched], wanted: Wanted) -> int:
        """How many of them have what is wanted."""
        own = dict(zip(self._numbers.tolist(), self._of.tolist(), strict=True))
        found = 0
        for each in touched:
            engine = own.get(each.track, NO_CLASS) if each.track is not None else NO_CLASS
            if each.key.startswith("m"):
                engine = own.pop(int(each.key[1:]), engine)
            if each.gone or (wanted.state is not None and each.state != wanted.state):
                continue
            label = self._labels.resolved(engine if each.label is None else each.label)
            found += self._is_wanted(label) and self._answers(label, each, wanted)
        if wanted.state in (None, "open"):
            for label, number in Counter(own.values()).items():
                if self._is_wanted(label) and self._answers(label, None, wanted):
                    found += number
        return found

    def _is_wanted(self, label: int) -> bool:
        return self._wanted is None or label == self._wanted

    def _answers(self, label: int, touched: _Touched | None, wanted: Wanted) -> bool:
        """Whether a track has the answer in any frame; where a person has given none, the label's default counts."""
        name = wanted.attribute
        if name is None:
            return True
        said = [] if touched is None else [each[name] for each in (touched.answers, *touched.changing) if name in each]
        if wanted.value is None:
            return bool(said)
        if any(_text(value) == wanted.value for value in said):
            return True
        if touched is not None and name in touched.answers:
            return False
        known: Label | None = self._labels.get(label)
        attribute = None if known is None else known.attribute(name)
        return attribute is not None and attribute.default is not None and _text(attribute.default) == wanted.value


def _text(value: Any) -> str:
    """An answer as it stands in an address."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:.12g}" if isinstance(value, int | float) else str(value)
