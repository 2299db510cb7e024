"""A label set: the labels that people and models give to signs, with everything that the tool knows about each label.

A version of a set is immutable. A label's ``id`` is given out once and never used again, so that stored edits, evidence
and exports keep their meaning. Labels are hidden or merged, never removed.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator, Sequence
from typing import Annotated, Final, Literal, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from tsr_engine.labels.name_matching import comparable

SCHEMA: Final = 1
"""Version of the file format."""
NO_LABEL: Final = -1
"""The id that means "no label of this set"."""
MAX_LABELS: Final = 5000
"""Largest number of labels in a set."""

Shape = Literal["triangle", "inverted triangle", "circle", "octagon", "diamond", "rectangle", "other"]
Category = Literal["prohibitory", "mandatory", "danger", "priority", "information", "direction", "additional", "other"]
Teach = Literal["sign", "background", "ignore"]
"""How a retraining uses a label: as a sign, as background, or as a region to ignore."""
AttributeKind = Literal["checkbox", "select", "number", "text"]
AttributeValue = bool | float | str
"""Type of a value: ``bool`` for a checkbox, ``float`` for a number, ``str`` for a select or a text."""


def _text(value: str) -> str:
    """One line of plain text without control characters or characters that turn the writing direction."""
    if value != value.strip() or not value:
        raise ValueError("it must not be empty, nor begin or end with a space")
    for character in value:
        if (
            unicodedata.category(character) in ("Cc", "Cs", "Zl", "Zp")
            or character in "\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
        ):
            raise ValueError(f"it holds the control character U+{ord(character):04X}")
    return value


def _text_or_nothing(value: str) -> str:
    return _text(value) if value else value


Text = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(_text)]
Key = Annotated[str, Field(min_length=1, max_length=100), AfterValidator(_text)]


class _Frozen(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


class Attribute(_Frozen):
    """A question about a sign beside its label, as in CVAT.

    Raises:
        ValueError: the values do not suit the kind.
    """

    name: Text
    kind: AttributeKind
    mutable: bool = False
    """True: the value may change from frame to frame; False: the whole track has one value."""
    values: tuple[Text, ...] = ()
    """Values of a ``select``."""
    low: float | None = None
    high: float | None = None
    default: AttributeValue | None = None
    """The default value; None: there is none."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if (self.kind == "select") != bool(self.values):
            raise ValueError(f"attribute {self.name!r}: a select has values, and nothing else has")
        if len(set(self.values)) != len(self.values):
            raise ValueError(f"attribute {self.name!r}: a value stands there twice")
        if self.kind != "number" and (self.low is not None or self.high is not None):
            raise ValueError(f"attribute {self.name!r}: only a number has low and high")
        if self.low is not None and self.high is not None and self.low > self.high:
            raise ValueError(f"attribute {self.name!r}: low is above high")
        if self.default is not None and (problem := self.problem(self.default)):
            raise ValueError(f"default: {problem}")
        return self

    def problem(self, value: AttributeValue) -> str | None:
        """Why ``value`` is invalid, as part of a sentence; None: it is valid."""
        name = f"attribute {self.name!r}"
        if self.kind == "checkbox":
            return None if isinstance(value, bool) else f"{name} must be true or false, not {value!r}"
        if self.kind == "number":
            if isinstance(value, bool) or not isinstance(value, int | float):
                return f"{name} must be a number, not {value!r}"
            if (self.low is not None and value < self.low) or (self.high is not None and value > self.high):
                return f"{name} must be within {self.low} and {self.high}, not {value!r}"
            return None
        if not isinstance(value, str):
            return f"{name} must be a text, not {value!r}"
        if self.kind == "select":
            return None if value in self.values else f"{name} must be one of {', '.join(self.values)}, not {value!r}"
        return None if len(value) <= 1000 else f"{name} must have at most 1000 characters"


class Label(_Frozen):
    """What a sign can be called.

    Raises:
        ValueError: an attribute stands there twice.
    """

    id: Annotated[int, Field(ge=0, le=2**31 - 1)]
    """Never used again after it was given to a label."""
    key: Key
    """Stable text, such as ``stop`` or ``C,3a``, by which models, files and the command line name labels."""
    name: Text
    """Name for people."""
    short: Annotated[str, Field(max_length=12), AfterValidator(_text_or_nothing)] = ""
    """Short name for pictures and narrow tables; empty: the first 12 characters of ``name``."""
    aliases: tuple[Text, ...] = ()
    """Names in other tools and countries."""
    shape: Shape = "other"
    category: Category = "other"
    pictogram: Annotated[str, Field(max_length=200)] = ""
    """Name of a drawing that ships with the package, or ``sha256:...`` of a stored PNG picture; empty: none."""
    attributes: tuple[Attribute, ...] = ()
    size_mm: Annotated[float, Field(gt=0, le=10_000)] | None = None
    """Usual width of the sign's face, mm; None: not known."""
    mirror: Key | None = None
    """Key of the label of its left-right mirror image; None: the mirror image is not a sign."""
    teach: Teach = "sign"
    colour: Annotated[str, Field(pattern=r"^#[0-9a-f]{6}$")] | None = None
    """Colour from another tool, ``#rrggbb``; None: chosen automatically."""
    pinned: Annotated[int, Field(ge=1, le=9)] | None = None
    """The digit key that selects this label in the review tool."""
    hidden: bool = False
    """No longer offered; tracks that have it keep it."""
    merged_into: Annotated[int, Field(ge=0)] | None = None
    """Id of the label that this one was merged into."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = [attribute.name for attribute in self.attributes]
        if len(set(names)) != len(names):
            raise ValueError(f"label {self.key!r}: an attribute stands there twice")
        return self

    @property
    def words(self) -> tuple[str, ...]:
        """Key, name and aliases."""
        return self.key, self.name, *self.aliases

    @property
    def shown_short(self) -> str:
        """``short``, or its default."""
        return self.short or self.name[:12]

    def attribute(self, name: str) -> Attribute | None:
        """The attribute with that name; None: the label has none."""
        return next((each for each in self.attributes if each.name == name), None)


class LabelSet(_Frozen):
    """One version of a label set.

    Raises:
        ValueError: ids, keys, names, aliases or pinned digits collide, or a merge leads nowhere or in a circle.
    """

    schema_version: Annotated[int, Field(alias="schema", ge=1)] = SCHEMA
    key: Key
    name: Text
    version: Annotated[int, Field(ge=1)] = 1
    next_id: Annotated[int, Field(ge=0)] = 0
    """Id of the next new label: above all ids ever used."""
    labels: Annotated[tuple[Label, ...], Field(max_length=MAX_LABELS)] = ()

    model_config = ConfigDict(populate_by_name=True)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        _unique("id", [(label.id, label) for label in self.labels])
        _unique("key", [(label.key.casefold(), label) for label in self.labels])
        _unique("pinned digit", [(label.pinned, label) for label in self.labels if label.pinned is not None])
        claims: dict[str, Label] = {}
        for label in self.labels:
            if label.merged_into is not None:
                continue
            for word in label.words:
                other = claims.setdefault(comparable(word), label)
                if other.id != label.id:
                    raise ValueError(
                        f"{word!r} names two labels, {other.key!r} and {label.key!r}; take it away from one of them"
                    )
        if any(label.id >= self.next_id for label in self.labels):
            raise ValueError("next_id must be above every id")
        places = {label.id: label for label in self.labels}
        for label in self.labels:
            seen, at = {label.id}, label
            while at.merged_into is not None:
                if at.merged_into not in places:
                    raise ValueError(f"label {at.key!r} is merged into {at.merged_into}, which is no label")
                if at.merged_into in seen:
                    raise ValueError(f"label {label.key!r} is merged into itself, by way of others")
                seen.add(at.merged_into)
                at = places[at.merged_into]
        return self

    def __iter__(self) -> Iterator[Label]:  # type: ignore[override]
        return iter(self.labels)

    def __len__(self) -> int:
        return len(self.labels)

    def get(self, label_id: int) -> Label | None:
        """The label with an id, even if it was merged; None: no label ever had the id."""
        return next((label for label in self.labels if label.id == label_id), None)

    def by_key(self, key: str) -> Label | None:
        """The label with a key, ignoring case; None: there is none."""
        wanted = key.casefold()
        return next((label for label in self.labels if label.key.casefold() == wanted), None)

    def mirror_images(self) -> dict[int, int]:
        """Pairs of labels that are left-right mirror images, by id: a training may mirror their crops."""
        images = {label.id: self.by_key(label.mirror) for label in self.labels if label.mirror is not None}
        return {label_id: image.id for label_id, image in images.items() if image is not None}

    def resolved(self, label_id: int) -> int:
        """The id that a merged label was replaced by; ``NO_LABEL`` and all other ids are returned unchanged."""
        return self.merged_ids().get(label_id, label_id)

    def merged_ids(self) -> dict[int, int]:
        """Id of each merged label -> id of the label that replaces it."""
        into = {label.id: label.merged_into for label in self.labels if label.merged_into is not None}
        found = dict(into)
        for label_id in found:
            while (at := into.get(found[label_id])) is not None:
                found[label_id] = at
        return found

    def offered(self) -> list[Label]:
        """Labels that can be assigned: neither hidden nor merged, in the order of the set."""
        return [label for label in self.labels if not label.hidden and label.merged_into is None]


def _unique(what: str, items: Sequence[tuple[object, Label]]) -> None:
    seen: dict[object, Label] = {}
    for value, label in items:
        if value in seen:
            raise ValueError(f"labels {seen[value].key!r} and {label.key!r} have one {what}: {value}")
        seen[value] = label
