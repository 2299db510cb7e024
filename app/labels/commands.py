"""The changes of a label set, as typed commands."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from app.body_model import Model
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.model import AttributeKind, AttributeValue, Category, Shape, Teach

_Word = Annotated[str, Field(min_length=1, max_length=200)]
_Key = Annotated[str, Field(min_length=1, max_length=100)]
_Id = Annotated[int, Field(ge=0, le=2**31 - 1)]
_Colour = Annotated[str, Field(pattern=r"^#[0-9a-f]{6}$", description="#rrggbb")]
_Digit = Annotated[int, Field(ge=1, le=9)]
_SetKey = Annotated[str, Field(min_length=1, max_length=64)]


class NewAttribute(Model):
    """See ``Attribute`` in ``tsr_engine.labels.model``."""

    name: _Word
    kind: AttributeKind
    mutable: bool = False
    values: Annotated[list[_Word], Field(max_length=1000, default_factory=list)]
    low: float | None = None
    high: float | None = None
    default: AttributeValue | None = None


class _Facts(Model):
    """Fields of a label; omitted fields stay as they are."""

    short: Annotated[str, Field(max_length=12)] = ""
    aliases: Annotated[list[_Word], Field(max_length=1000, default_factory=list)]
    shape: Shape = "other"
    category: Category = "other"
    attributes: Annotated[list[NewAttribute], Field(max_length=100, default_factory=list)]
    size_mm: Annotated[float, Field(gt=0, le=10_000)] | None = None
    mirror: _Key | None = None
    teach: Teach = "sign"
    colour: _Colour | None = None
    pinned: _Digit | None = None

    def facts(self) -> JsonObject:
        """The fields that were sent, without those that identify the label."""
        return self.model_dump(exclude_unset=True, exclude={"type", "id"})


class AddLabel(_Facts):
    """Add a label; its key is made from the name if none is sent."""

    type: Literal["add"]
    name: _Word
    key: _Key | None = None
    pictogram: Annotated[str, Field(max_length=200, description="a drawing that ships with tsr")] = ""


class UpdateLabel(_Facts):
    """Change the fields that are sent; null removes a value."""

    type: Literal["update"]
    id: _Id
    name: _Word | None = None


class MergeLabels(Model):
    """Replace the label ``id`` by ``into`` from now on."""

    type: Literal["merge"]
    id: _Id
    into: _Id


class HideLabel(Model):
    """Stop offering the label."""

    type: Literal["hide"]
    id: _Id


class ShowLabel(Model):
    """Offer a hidden label again."""

    type: Literal["show"]
    id: _Id


class SetPicture(Model):
    """Set the picture of the label: PNG, at most 512 px and 256 KB; null removes it."""

    type: Literal["picture"]
    id: _Id
    png: Annotated[str, Field(min_length=1, max_length=400_000, description="base64")] | None


class UndoChange(Model):
    """Undo the change that made a version."""

    type: Literal["undo"]
    version: Annotated[int, Field(ge=1, le=2**31 - 1)]


class AdoptSet(Model):
    """Add the missing labels of another set."""

    type: Literal["adopt"]
    set: _SetKey


LabelChange = Annotated[
    AddLabel | UpdateLabel | MergeLabels | HideLabel | ShowLabel | SetPicture | UndoChange | AdoptSet,
    Field(discriminator="type"),
]
