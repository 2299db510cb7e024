"""What a file brings along that the label set does not have: labels, and attributes of labels.

Readers hand over what stands in the file; here it becomes labels of the set, is refused with a list, or left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from pydantic import ValidationError

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.dataset import NONE, Skipped, Track
from tsr_engine.exchange.labels import LabelMatcher
from tsr_engine.io.plain_numbers import real_number
from tsr_engine.labels.changes import key_of, next_version
from tsr_engine.labels.model import MOST_LABELS, Attribute, AttributeKind, AttributeValue, Label, LabelSet
from tsr_engine.labels.refusals import ChangeError
from tsr_engine.labels.wording import comparable

__all__ = ["Declared", "Unknown", "UnknownLabels", "attributed", "unknown_refused", "with_new_labels"]

_LISTED = 8
"""Names in the sentence of a refusal; its list has all."""
_SUGGESTED = 200
"""Names for which like ones are looked for, which takes its time."""


@dataclass(frozen=True, slots=True)
class Declared:
    """What a file says of a label before it uses it.

    Attributes:
        attributes: its questions.
        colour: ``#rrggbb``; None: it has none.
    """

    attributes: tuple[Attribute, ...] = ()
    colour: str | None = None


@dataclass(frozen=True, slots=True)
class Unknown:
    """A name in a file that no label has.

    Attributes:
        name: as it stands in the file.
        tracks: how many tracks have it.
        boxes: how many of their boxes.
        suggestions: labels that may be meant.
        frame: of its clearest box.
        box: that box, px edges.
        place: of the first box in the file, in words.
    """

    name: str
    tracks: int
    boxes: int
    suggestions: tuple[Label, ...]
    frame: int
    box: tuple[float, float, float, float]
    place: str


class UnknownLabels(ImportFormatError):
    """A file has names that no label has, and nobody has said what becomes of them.

    The message does not say what to do: the command line, the HTTP API and the page have their own words for it.

    Attributes:
        labels: the names.
    """

    def __init__(self, message: str, labels: Sequence[Unknown]) -> None:
        super().__init__(message)
        self.labels = tuple(labels)


def unknown_refused(file: str, labels: LabelSet, matcher: LabelMatcher, found: Sequence[Unknown]) -> UnknownLabels:
    """The error for names that no label has.

    Args:
        file: for messages.
        labels: the set.
        matcher: suggests.
        found: the names, in the order of the file.
    """
    order = sorted(found, key=lambda each: (-each.boxes, each.name))
    listed = [
        replace(each, suggestions=tuple(matcher.suggestions(each.name))) if at < _SUGGESTED else each
        for at, each in enumerate(order)
    ]
    words = []
    for each in listed[:_LISTED]:
        like = f"; like {' or '.join(repr(label.key) for label in each.suggestions)}" if each.suggestions else ""
        words.append(f"{each.name[:80]!r} ({_count(each.tracks, 'track')}, {_count(each.boxes, 'box')}{like})")
    more = f" and {len(listed) - _LISTED} more" if len(listed) > _LISTED else ""
    one = len(listed) == 1
    return UnknownLabels(
        f"{file}: {_count(len(listed), 'name')} {'is' if one else 'are'} no label of {labels.name}: "
        f"{', '.join(words)}{more}. {'It' if one else 'The first'} stands in {found[0].place}.",
        listed,
    )


def with_new_labels(
    labels: LabelSet, names: Iterable[str], declared: Mapping[str, Declared], file: str
) -> tuple[LabelSet, dict[str, int]]:
    """The set with labels for names that it does not have, and their ids.

    Names that differ by case, spaces and punctuation alone become one label.

    Args:
        labels: the set.
        names: in the order in which they get their ids.
        declared: what the file says of them, by name.
        file: for messages.

    Raises:
        ImportFormatError: a name can be that of no label, or there are too many.
    """
    ids: dict[str, int] = {}
    known: dict[str, int] = {}
    added: list[Label] = []
    taken = {comparable(word) for label in labels for word in (label.key, label.name, *label.aliases)}
    for name in names:
        same = comparable(name)
        if same in known:
            ids[name] = known[same]
            continue
        key = key_of(name, lambda key: comparable(key) in taken)  # noqa: B023 - called at once
        about = declared.get(name, Declared())
        try:
            label = Label(
                id=labels.next_id + len(added),
                key=key,
                name=name.strip(),
                attributes=about.attributes,
                colour=about.colour,
            )
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            raise ImportFormatError(
                f"{file}: {name[:80]!r} cannot become a label: {first['msg']}. Say which label it is with --label."
            ) from None
        known[same] = ids[name] = label.id
        taken |= {comparable(key), same}
        added.append(label)
    if len(labels) + len(added) > MOST_LABELS:
        raise ImportFormatError(
            f"{file}: brings {len(added)} new labels; with the {len(labels)} of {labels.name} that is more than "
            f"{MOST_LABELS}, the most that a set has. Leave them out with unknown=skip, or map them.",
            "too_large",
        )
    if not added:
        return labels, ids
    return _replaced(labels, (*labels.labels, *added), file), ids


def _replaced(labels: LabelSet, every: tuple[Label, ...], file: str) -> LabelSet:
    """The set with other labels, held to its rules."""
    try:
        return next_version(labels, every, max([labels.next_id, *(label.id + 1 for label in every)]))
    except ChangeError as error:
        raise ImportFormatError(
            f"{file}: its labels do not go together with {labels.name}. {error} Map them with --label."
        ) from None


Said = Mapping[str, Any] | None
"""What a row says beside its box, by name; None: nothing."""


@dataclass(slots=True)
class _Tellings:
    """Sentences about attributes, each kind once with its number."""

    counts: dict[tuple[str, str], int] = field(default_factory=dict)

    def count(self, what: str, reason: str) -> None:
        self.counts[what, reason] = self.counts.get((what, reason), 0) + 1

    def skipped(self) -> list[Skipped]:
        return [
            Skipped(f"{what} ({count} times)" if count > 1 else what, reason)
            for (what, reason), count in self.counts.items()
        ]


def attributed(
    labels: LabelSet,
    tracks: list[Track],
    rows: Mapping[int, Sequence[Said]],
    declared: Mapping[int, Declared],
    add: Callable[[int], bool],
    file: str,
) -> tuple[LabelSet, list[Skipped]]:
    """Give tracks the attributes that rows of a file say; those that a label does not have are added to it, or told.

    Args:
        labels: the set.
        tracks: those that rows say something of are replaced.
        rows: place of a track -> what is said in each of its frames.
        declared: what the file says of labels, by id.
        add: whether a label, by its id, gets the attributes that it does not have.
        file: for messages.

    Returns:
        The set, and what was left out.
    """
    reported = _Tellings()
    by_label: dict[int, dict[str, list[list[Any]]]] = {}
    for place, said in rows.items():
        questions = by_label.setdefault(tracks[place].label, {})
        for name, column in _columns(said).items():
            questions.setdefault(name, []).append(column)
    known: dict[int, dict[str, Attribute]] = {}
    changed: dict[int, Label] = {}
    for label_id, questions in by_label.items():
        label = labels.get(label_id)
        if label is None:
            continue
        found = {each.name: each for each in label.attributes}
        if add(label_id):
            said_here = {each.name: each for each in declared.get(label_id, Declared()).attributes}
            for name, columns in questions.items():
                new = _asked(found.get(name), said_here.get(name), name, columns)
                if new is not None:
                    found[name] = new
            if tuple(found.values()) != label.attributes:
                changed[label_id] = label.model_copy(update={"attributes": tuple(found.values())})
        known[label_id] = found
    if changed:
        labels = _replaced(labels, tuple(changed.get(label.id, label) for label in labels), file)
    for place, said in rows.items():
        track = tracks[place]
        label = labels.get(track.label)
        tracks[place] = _given(track, said, known.get(track.label, {}), None if label is None else label.name, reported)
    return labels, reported.skipped()


def _columns(said: Sequence[Said]) -> dict[str, list[Any]]:
    """What the rows of a track say, by name."""
    out: dict[str, list[Any]] = {}
    before: Said = None
    for row in said:
        # rows between two key frames are one object
        if row is None or row is before:
            continue
        before = row
        for name, value in row.items():
            out.setdefault(name, []).append(value)
    return out


def _asked(known: Attribute | None, said: Attribute | None, name: str, columns: list[list[Any]]) -> Attribute | None:
    """The attribute that holds all answers; None: it can be none."""
    attribute = known or said
    if attribute is None:
        mutable = any(any(value != column[0] for value in column) for column in columns)
        try:
            return Attribute(name=name, kind=_kind(columns), mutable=mutable)
        except ValidationError:
            return None
    if attribute.kind != "select":
        return attribute
    new = dict.fromkeys(as_said for column in columns for value in column if (as_said := _plain(value)))
    values = (*attribute.values, *(value for value in new if value not in attribute.values))
    try:
        return Attribute(**(attribute.model_dump() | {"values": values}))
    except ValidationError:
        return attribute


def _kind(columns: list[list[Any]]) -> AttributeKind:
    values = [value for column in columns for value in column]
    if all(isinstance(value, bool) or str(value).casefold() in ("true", "false") for value in values):
        return "checkbox"
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return "number"
    return "text"


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:.12g}" if isinstance(value, int | float) else str(value).strip()


def _answer(attribute: Attribute, value: Any) -> AttributeValue:
    """A value as the attribute takes it.

    Raises:
        ValueError: it does not; part of a sentence says why.
    """
    answer: AttributeValue = _plain(value)
    if attribute.kind == "checkbox":
        word = str(answer).casefold()
        answer = word in ("true", "1") if word in ("true", "false", "0", "1") else answer
    elif attribute.kind == "number":
        number = math.nan
        with suppress(ValueError, OverflowError):
            number = real_number(value) if isinstance(value, str) else float(value)
        answer = number if math.isfinite(number) else answer
    problem = attribute.problem(answer)
    if problem is not None:
        raise ValueError(problem)
    return answer


def _given(
    track: Track, said: Sequence[Said], known: Mapping[str, Attribute], label: str | None, reported: _Tellings
) -> Track:
    """The track with the answers that rows give."""
    whole: dict[str, AttributeValue] = {}
    changing: dict[str, Any] = {}
    for name in _columns(said):
        attribute = known.get(name)
        if attribute is None:
            why = (
                f"The label {label!r} has no such attribute. Import with unknown=add to add it."
                if track.label != NONE and label is not None
                else "Tracks without label have none."
            )
            reported.count(f"attribute {name[:80]!r}", why)
            continue
        answers = np.full(len(track.frames), None, object)
        for k, row in enumerate(said):
            if row is not None and name in row:
                try:
                    answers[k] = _answer(attribute, row[name])
                except ValueError as error:
                    reported.count(f"answers to {name[:80]!r} of {label!r}", f"The set says: {str(error)[:200]}.")
        given = [answer for answer in answers.tolist() if answer is not None]
        if not given:
            continue
        if attribute.mutable:
            changing[name] = answers
            continue
        if any(answer != given[0] for answer in given):
            reason = f"{label!r} has one answer for a whole track; the first was taken."
            reported.count(f"answers to {name[:80]!r} that change within a track", reason)
        whole[name] = given[0]
    return replace(track, attributes=whole, changing=changing)


def _count(number: int, word: str) -> str:
    return f"{number} {word if number == 1 else 'boxes' if word == 'box' else word + 's'}"
