"""Filters of the search as database queries."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, time
from typing import Annotated, Literal

from pydantic import Field
from sqlalchemy import ColumnElement, and_, false, literal_column, or_, select, true
from sqlalchemy.orm import Session

from app.body_model import PLAIN, Model
from app.errors import Invalid
from app.labels.store import default_key, newest, set_keys
from app.search.rows import UNANSWERED, attribute_text
from app.storage.models import SearchAttribute, SearchRun, SearchTrack, Video, VideoTag
from tsr_engine.labels.matching import LabelFinder, unknown_label
from tsr_engine.labels.model import NO_LABEL, Label, LabelSet

State = Literal["open", "needs_work", "accepted", "rejected", "ignored"]
_Word = Annotated[str, Field(min_length=1, max_length=200, pattern=PLAIN)]
_Share = Annotated[float, Field(ge=0, le=1)]
_Pixels = Annotated[float, Field(ge=0, le=1e6)]
_Moment = Annotated[str, Field(min_length=1, max_length=40, pattern=PLAIN)]
_DAY_S = 86_400
NO_LABEL_WORD = "none"
"""Value that finds signs without a label of the set, and signs that were not classified."""


class SearchFilters(Model):
    """Filters of tracks. All given filters must hold; of several values of a filter, one must (of attributes, all)."""

    label: Annotated[list[_Word], Field(max_length=100)] = Field(
        [], description="key, name, alias, short or #number; else words of a key, name or alias"
    )
    state: Annotated[list[State], Field(max_length=5)] = Field([], description="ignored: a region to ignore")
    uncertainty_min: _Share | None = None
    uncertainty_max: _Share | None = None
    size_min: _Pixels | None = Field(None, description="longer side of the largest box, px")
    size_max: _Pixels | None = None
    attribute: Annotated[list[_Word], Field(max_length=20)] = Field(
        [], description="name=value or name; every one must hold"
    )
    author: Annotated[list[_Word], Field(max_length=50)] = Field([], description="who edited the track last")
    since: _Moment | None = Field(None, description="last edit at or after this day or moment, UTC")
    until: _Moment | None = Field(None, description="last edit up to this day, or before this moment, UTC")
    text: Annotated[str, Field(max_length=500, pattern=PLAIN)] = Field("", description="words that notes must have")
    tag: Annotated[list[_Word], Field(max_length=50)] = Field([], description="of the video")
    video: Annotated[str, Field(max_length=500, pattern=PLAIN)] = Field("", description="id, or words of the name")
    runs: Literal["current", "all"] = Field("current", description="current: the current run of each video")


class MeantLabel(Model):
    """A label that a word of the request means."""

    set: str
    id: int
    name: str


def conditions(session: Session, filters: SearchFilters) -> list[ColumnElement[bool]]:
    """Convert the filters to conditions on ``search_tracks``.

    Raises:
        Invalid: no set has a label, a time is invalid, or a range is empty.
    """
    row = SearchTrack
    where: list[ColumnElement[bool]] = [row.current == true()] if filters.runs == "current" else []
    if filters.label:
        where.append(has_label(session, filters.label))
    if filters.state:
        where.append(row.state.in_(filters.state))
    for column, low, high, name in (
        (row.uncertainty, filters.uncertainty_min, filters.uncertainty_max, "uncertainty"),
        (row.size, filters.size_min, filters.size_max, "size"),
    ):
        if low is not None and high is not None and low > high:
            raise Invalid(f"The smallest {name}, {low:g}, is above the largest, {high:g}.", field=f"{name}_min")
        where += [column >= low] if low is not None else []
        where += [column <= high] if high is not None else []
    where += [_has_attribute(session, word) for word in filters.attribute]
    if filters.author:
        where.append(row.author.in_(filters.author))
    if filters.since is not None:
        where.append(row.edited >= _seconds(filters.since, "since", last=False))
    if filters.until is not None:
        where.append(and_(row.edited > 0, row.edited < _seconds(filters.until, "until", last=True)))
    if words := filters.text.casefold().split():
        where += [has_notes(), *(row.notes.contains(word, autoescape=True) for word in words)]
    if filters.tag:
        where.append(row.video_id.in_(select(VideoTag.video_id).where(VideoTag.tag.in_(filters.tag))))
    if filters.video.strip():
        where.append(row.video_id.in_(_videos(session, filters.video)))
    return where or [true()]


def has_notes() -> ColumnElement[bool]:
    """Condition for tracks with notes, in the form of their index."""
    return SearchTrack.notes != literal_column("''")


def labels_for_words(session: Session, words: Sequence[str]) -> list[MeantLabel]:
    """Labels that words mean, in the sets that the search's tables use.

    A word that no set has as a whole means the labels with it in a key, a name or an alias.

    Raises:
        Invalid: a word means no label.
    """
    return [
        MeantLabel(set=labels.key, id=label.id, name=label.name) for labels, label in _resolve_words(session, words)
    ]


def named_labels(labels: LabelSet, word: str) -> list[Label]:
    """Labels of one set that a word means.

    A number first means the inscription: ``60`` finds every label with the short name 60. ``#60`` is an id.
    """
    text = word.strip()
    if text.isdecimal():
        with_inscription = [label for label in labels if label.short == text and label.merged_into is None]
        if with_inscription:
            return with_inscription
    match = LabelFinder(labels).find(text)
    return [] if match is None else [match.label]


def _resolve_words(session: Session, words: Sequence[str], exact_only: bool = False) -> list[tuple[LabelSet, Label]]:
    sets = _sets_in_use(session)
    found: dict[tuple[str, int], tuple[LabelSet, Label]] = {}
    for word in words:
        meant = [(labels, label) for labels in sets for label in named_labels(labels, word)]
        if not meant and word.strip().casefold() == NO_LABEL_WORD:
            continue
        if not meant and not exact_only:
            meant = [(labels, label) for labels in sets for label in LabelFinder(labels).with_words(word)]
        if not meant:
            raise Invalid(unknown_label(word, *sets), field="label", code="no_such_label")
        found |= {(labels.key, label.id): (labels, label) for labels, label in meant}
    return [*found.values()]


def _sets_in_use(session: Session) -> list[LabelSet]:
    """Label sets of videos with runs in the tables, and the set of videos that name none."""
    named = select(Video.label_set).where(Video.label_set.is_not(None)).distinct()
    used = {default_key(session), *session.scalars(named), *session.scalars(select(SearchRun.set_key).distinct())}
    return [newest(session, key) for key in set_keys(session) if key in used]


def has_label(session: Session, words: Sequence[str], exact_only: bool = False) -> ColumnElement[bool]:
    """Condition for tracks with a label that one of the words means, or with a label that was merged into it.

    Args:
        session: reads.
        words: as for :func:`labels_for_words`.
        exact_only: a part of a name means no label.

    Raises:
        Invalid: a word means no label.
    """
    meant = _resolve_words(session, words, exact_only)
    wanted: list[ColumnElement[bool]] = []
    for labels in {labels.key: labels for labels, _ in meant}.values():
        targets = {label.id for other, label in meant if other.key == labels.key}
        merged = labels.merged_ids()
        ids = [label.id for label in labels if merged.get(label.id, label.id) in targets]
        wanted.append(and_(SearchTrack.set_key == labels.key, SearchTrack.label.in_(ids)))
    if any(word.strip().casefold() == NO_LABEL_WORD for word in words):
        wanted.append(SearchTrack.label == NO_LABEL)
    return or_(false(), *wanted)


def _has_attribute(session: Session, word: str) -> ColumnElement[bool]:
    name, equals, value = (part.strip() for part in word.partition("="))
    return has_attribute(session, name, value if equals else None)


def has_attribute(session: Session, name: str, value: str | None) -> ColumnElement[bool]:
    """Condition for tracks with a value of an attribute in some frame.

    Args:
        session: reads.
        name: name of the attribute.
        value: the value; without an answer the default of the label counts. None: any value that a person has set.
    """
    row = SearchAttribute
    values = select(row.run_id).where(row.run_id == SearchTrack.run_id, row.key == SearchTrack.key, row.name == name)
    if value is None:
        return values.where(row.value != UNANSWERED).exists()
    wanted = {attribute_text(value), *(attribute_text(tick) for tick in (True, False) if value == json.dumps(tick))}
    is_set = values.where(row.value.in_(wanted)).exists()
    by_default: list[ColumnElement[bool]] = []
    for labels in _sets_in_use(session):
        ids = [label.id for label in labels if _default(labels, label.id, name) in wanted]
        if ids:
            by_default.append(and_(SearchTrack.set_key == labels.key, SearchTrack.label.in_(ids)))
    if not by_default:
        return is_set
    is_unanswered = or_(~values.exists(), values.where(row.value == UNANSWERED).exists())
    return or_(is_set, and_(or_(*by_default), is_unanswered))


def _default(labels: LabelSet, label_id: int, name: str) -> str | None:
    label = labels.get(labels.resolved(label_id))
    attribute = None if label is None else label.attribute(name)
    return None if attribute is None or attribute.default is None else attribute_text(attribute.default)


def _seconds(text: str, field: str, *, last: bool) -> int:
    """Convert a day or a time to seconds since 1970; ``last``: the end of a day."""
    try:
        moment = datetime.fromisoformat(text.strip())
    except ValueError:
        raise Invalid(
            f"Expected a day such as 2026-11-01 or a moment such as 2026-11-01T08:30. Got {text!r}.", field=field
        ) from None
    moment = moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)
    is_day = moment.time() == time() and len(text.strip()) <= len("2026-11-01")
    return int(moment.timestamp()) + (_DAY_S if last and is_day else 0)


def _videos(session: Session, text: str) -> Iterable[str]:
    """Ids of the videos with that id, or with all words in their names; Python compares them, to fold Unicode case."""
    words = text.casefold().split()
    rows = session.execute(select(Video.id, Video.name))
    return [
        video_id
        for video_id, name in rows
        if video_id == text.strip() or all(word in name.casefold() for word in words)
    ]
