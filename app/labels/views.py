"""Views of label sets for the page."""

from __future__ import annotations

import hashlib

from app.shapes import Model, Moment
from tsr_engine.labels.model import AttributeKind, AttributeValue, Category, Label, LabelSet, Shape, Teach

__all__ = [
    "AttributeView",
    "Brought",
    "Change",
    "KnownLabel",
    "LabelSetView",
    "LabelVersion",
    "LabelView",
    "label_view",
]


class AttributeView(Model):
    """A question about a sign beside its label; see ``Attribute`` in ``tsr_engine.labels.model``."""

    name: str
    kind: AttributeKind
    mutable: bool
    """The answer may change from frame to frame."""
    values: list[str]
    """Answers of a select."""
    low: float | None
    high: float | None
    default: AttributeValue | None


class LabelView(Model):
    """One label of a set."""

    id: int
    key: str
    name: str
    short: str
    """Empty: the first 12 characters of the name stand for it."""
    aliases: list[str]
    picture: str | None
    """Address of the pictogram; null: it has none."""
    shape: Shape
    category: Category
    attributes: list[AttributeView]
    size_mm: float | None
    mirror: str | None
    """Key of the label that its mirror image is."""
    teach: Teach
    """What a retraining makes of it."""
    colour: str | None
    """`#rrggbb`."""
    pinned: int | None
    """1 to 9."""
    hidden: bool
    """Not offered any more."""
    merged_into: int | None
    """Id of the label that stands for it."""


class LabelSetView(Model):
    """One set."""

    key: str
    name: str
    version: int
    labels: int
    """How many labels it has; hidden and merged ones too."""
    default: bool
    """Videos use it that name none."""
    shipped: bool
    """It ships with tsr; the library may have changed it since."""


class LabelVersion(Model):
    """One version of a set."""

    version: int
    author: str
    created: Moment | None
    """None: it is as it came with tsr."""
    sentence: str
    undoes: int | None


class Change(Model):
    """What a change gave."""

    version: int
    label: LabelView | None
    sentence: str


class KnownLabel(Model):
    """A label of a file that the set has."""

    name: str
    """In the file."""
    id: int
    key: str


class RefusedLabel(Model):
    """A name of a file that no label can have."""

    name: str
    reason: str


class Brought(Model):
    """What came of a file of labels."""

    version: int
    sentence: str
    created: bool
    """The set was made from the file."""
    added: list[LabelView]
    known: list[KnownLabel]
    refused: list[RefusedLabel]
    reported: list[str]
    """What the file says and a set cannot hold."""


def label_view(labels: LabelSet, label: Label) -> LabelView:
    """A label as pages see it."""
    return LabelView.from_row(
        label,
        aliases=list(label.aliases),
        picture=_picture(labels.key, label),
        attributes=[AttributeView.from_row(attribute, values=list(attribute.values)) for attribute in label.attributes],
    )


def _picture(key: str, label: Label) -> str | None:
    """An address that changes with the picture, so that a browser never shows one that was replaced."""
    if not label.pictogram:
        return None
    look = hashlib.sha256(label.pictogram.encode()).hexdigest()[:8]
    return f"/api/labels/{label.id}.png?set={key}&look={look}"
