"""Handles labels that a file has and the set lacks: they are added to the set, or refused with a list."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from pydantic import ValidationError

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.box_rules import Edges
from tsr_engine.exchange.labels import LabelMatcher
from tsr_engine.labels.changes import key_of, next_version
from tsr_engine.labels.conflicts import ChangeError
from tsr_engine.labels.model import MAX_LABELS, Attribute, Label, LabelSet
from tsr_engine.labels.name_matching import comparable
from tsr_engine.plural import plural

_MAX_LISTED = 8
"""Most names in the sentence of a refusal; its list has all of them."""
_MAX_SUGGESTED = 200
"""Most names for which similar labels are searched, because the search is slow."""


@dataclass(frozen=True, slots=True)
class DeclaredLabel:
    """A label as a file declares it.

    Attributes:
        attributes: the label's attributes.
        colour: ``#rrggbb``; None: not declared.
    """

    attributes: tuple[Attribute, ...] = ()
    colour: str | None = None


@dataclass(frozen=True, slots=True)
class UnknownLabel:
    """A name in a file that matches no label.

    Attributes:
        name: as the file writes it.
        tracks: number of tracks with this name.
        boxes: number of their boxes.
        suggestions: labels that the name may mean.
        similar: whether they resemble the name; else they only contain it.
        frame: frame of its clearest box.
        box: the clearest box, px edges.
        location: place of the first box in the file, in words.
    """

    name: str
    tracks: int
    boxes: int
    suggestions: tuple[Label, ...]
    similar: bool
    frame: int
    box: Edges
    location: str


class UnknownLabels(ImportFormatError):
    """Raised if a file has names that match no label, and the caller has not said what to do with them.

    The message gives no advice: the command line, the HTTP API and the page each add their own.

    Attributes:
        labels: the names.
    """

    def __init__(self, message: str, labels: Sequence[UnknownLabel]) -> None:
        super().__init__(message)
        self.labels = tuple(labels)


def unknown_labels_error(
    file: str, labels: LabelSet, matcher: LabelMatcher, found: Sequence[UnknownLabel]
) -> UnknownLabels:
    """The error for names that match no label.

    Args:
        file: for messages.
        labels: the label set.
        matcher: finds suggestions.
        found: the names, in the order of the file.
    """
    order = sorted(found, key=lambda each: (-each.boxes, each.name))
    listed = [_with_suggestions(each, matcher) if index < _MAX_SUGGESTED else each for index, each in enumerate(order)]
    descriptions = []
    for each in listed[:_MAX_LISTED]:
        like = f"; like {' or '.join(repr(label.key) for label in each.suggestions)}" if each.suggestions else ""
        descriptions.append(
            f"{each.name[:80]!r} ({plural(each.tracks, 'track')}, {plural(each.boxes, 'box', 'boxes')}{like})"
        )
    more = f" and {len(listed) - _MAX_LISTED} more" if len(listed) > _MAX_LISTED else ""
    one = len(listed) == 1
    return UnknownLabels(
        f"{file}: {plural(len(listed), 'name')} {'is' if one else 'are'} no label of {labels.name}: "
        f"{', '.join(descriptions)}{more}. {'It' if one else 'The first'} stands in {found[0].location}.",
        listed,
    )


def _with_suggestions(unknown: UnknownLabel, matcher: LabelMatcher) -> UnknownLabel:
    found = matcher.suggestions(unknown.name)
    return replace(unknown, suggestions=found.labels, similar=found.similar)


def with_new_labels(
    labels: LabelSet, names: Iterable[str], declared: Mapping[str, DeclaredLabel], file: str
) -> tuple[LabelSet, dict[str, int]]:
    """Add labels for names that the set lacks; return the set and the ids of these names.

    Names that differ by case, spaces and punctuation alone become one label.

    Args:
        labels: the label set.
        names: in the order of their new ids.
        declared: the file's declarations, by name.
        file: for messages.

    Raises:
        ImportFormatError: a name cannot become a label, or there are too many.
    """
    ids: dict[str, int] = {}
    known: dict[str, int] = {}
    added: list[Label] = []
    used_names = {comparable(word) for label in labels for word in label.words}
    for name in names:
        normalized_name = comparable(name)
        if normalized_name in known:
            ids[name] = known[normalized_name]
            continue
        key = key_of(name, lambda key: comparable(key) in used_names)  # noqa: B023 - called at once
        declaration = declared.get(name, DeclaredLabel())
        try:
            label = Label(
                id=labels.next_id + len(added),
                key=key,
                name=name.strip(),
                attributes=declaration.attributes,
                colour=declaration.colour,
            )
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            raise ImportFormatError(
                f"{file}: {name[:80]!r} cannot become a label: {first['msg']}. Say which label it is with --label."
            ) from None
        known[normalized_name] = ids[name] = label.id
        used_names |= {comparable(key), normalized_name}
        added.append(label)
    if len(labels) + len(added) > MAX_LABELS:
        raise ImportFormatError(
            f"{file}: has {len(added)} new labels; with the {len(labels)} of {labels.name} that is more than "
            f"{MAX_LABELS}, the most that a set holds. Leave them out with unknown=skip, or map them.",
            "too_large",
        )
    if not added:
        return labels, ids
    return with_labels(labels, (*labels.labels, *added), file), ids


def with_labels(labels: LabelSet, all_labels: tuple[Label, ...], file: str) -> LabelSet:
    """The set with other labels, checked against its rules."""
    try:
        return next_version(labels, all_labels, max([labels.next_id, *(label.id + 1 for label in all_labels)]))
    except ChangeError as error:
        raise ImportFormatError(
            f"{file}: its labels conflict with {labels.name}. {error} Map them with --label."
        ) from None
