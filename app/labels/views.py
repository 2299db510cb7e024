"""Views of label sets for the page."""

from __future__ import annotations

import hashlib

from app.body_model import Model, Moment
from tsr_engine.labels.model import AttributeKind, AttributeValue, Category, Label, LabelSet, Shape, Teach


class AttributeView(Model):
    """A further property of a sign; see ``Attribute`` in ``tsr_engine.labels.model``."""

    name: str
    kind: AttributeKind
    mutable: bool
    """Whether the value may change from frame to frame."""
    values: list[str]
    """Values of a select."""
    low: float | None
    high: float | None
    default: AttributeValue | None


class LabelView(Model):
    """One label of a set."""

    id: int
    key: str
    name: str
    short: str
    """Short name; empty: the first 12 characters of the name are used."""
    aliases: list[str]
    picture: str | None
    """Address of the pictogram; null: it has none."""
    shape: Shape
    category: Category
    attributes: list[AttributeView]
    size_mm: float | None
    mirror: str | None
    """Key of the label of its mirror image."""
    teach: Teach
    """Use in retraining: sign, background or ignore."""
    colour: str | None
    """`#rrggbb`."""
    pinned: int | None
    """Digit key, 1 to 9."""
    hidden: bool
    """Whether it is no longer offered."""
    merged_into: int | None
    """Id of the label that replaces it."""


class LabelSetView(Model):
    """One set."""

    key: str
    name: str
    version: int
    labels: int
    """Number of labels, hidden and merged ones included."""
    default: bool
    """Whether videos that name no set use it."""
    shipped: bool
    """Whether it ships with tsr; the library may have changed it since."""


class LabelVersion(Model):
    """One version of a set."""

    version: int
    author: str
    created: Moment | None
    """None: the version that ships with tsr."""
    sentence: str
    undoes: int | None


class Change(Model):
    """Result of a change."""

    version: int
    label: LabelView | None
    sentence: str


class KnownLabel(Model):
    """A label of a file that the set has."""

    name: str
    """Name in the file."""
    id: int
    key: str


class RefusedLabel(Model):
    """A name of a file that is not allowed as a label."""

    name: str
    reason: str


class Brought(Model):
    """Result of importing a file of labels."""

    version: int
    sentence: str
    created: bool
    """Whether the set was made from the file."""
    added: list[LabelView]
    known: list[KnownLabel]
    refused: list[RefusedLabel]
    reported: list[str]
    """Contents of the file that a set cannot hold."""


def label_view(labels: LabelSet, label: Label) -> LabelView:
    """Convert a label to its view."""
    return LabelView.from_row(
        label,
        aliases=list(label.aliases),
        picture=_picture(labels.key, label),
        attributes=[AttributeView.from_row(attribute, values=list(attribute.values)) for attribute in label.attributes],
    )


def _picture(key: str, label: Label) -> str | None:
    """An address that changes with the picture, so that browsers never show a replaced one."""
    if not label.pictogram:
        return None
    look = hashlib.sha256(label.pictogram.encode()).hexdigest()[:8]
    return f"/api/labels/{label.id}.png?set={key}&look={look}"
