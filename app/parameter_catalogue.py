"""Every parameter with its range, for dialogs."""

from __future__ import annotations

import types
import typing
from typing import Literal

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from app.body_model import Model
from tsr_engine.params import PRESETS, Params
from tsr_engine.params.replayable import is_replayable

_KINDS: dict[object, Literal["number", "integer", "boolean"]] = {bool: "boolean", int: "integer", float: "number"}


class Parameter(Model):
    """One parameter of the engine."""

    section: str
    name: str
    type: Literal["number", "integer", "boolean", "choice", "text"]
    default: bool | int | float | str | list[float] | None
    low: float | None
    high: float | None
    choices: list[str] | None
    description: str
    replayable: bool
    """A what-if may change it."""
    presets: dict[str, bool | int | float | str | list[float] | None]
    """Preset -> value where it departs."""


def parameters() -> list[Parameter]:
    """All parameters of the engine, in the engine's order."""
    found = []
    for section, leaf in Params.names():
        model = Params.model_fields[section].annotation
        assert isinstance(model, type)
        assert issubclass(model, BaseModel)
        found.append(_parameter(section, leaf, model.model_fields[leaf]))
    return found


def _parameter(section: str, name: str, field: FieldInfo) -> Parameter:
    kind, choices = _kind(field.annotation)
    limits = {
        limit: float(v)
        for item in field.metadata
        for limit in ("ge", "gt", "le", "lt")
        if (v := _limit(item, limit)) is not None
    }
    return Parameter(
        section=section,
        name=name,
        type=kind,
        default=_plain(field.default),
        low=limits.get("ge", limits.get("gt")) if kind in ("number", "integer") else None,
        high=limits.get("le", limits.get("lt")) if kind in ("number", "integer") else None,
        choices=choices,
        description=field.description or "",
        replayable=is_replayable(f"{section}.{name}"),
        presets={preset: _plain(values[name]) for preset, values in PRESETS.items() if name in values},
    )


def _limit(item: object, name: str) -> float | None:
    value = getattr(item, name, None)
    return value if isinstance(value, int | float) else None


def _kind(annotation: object) -> tuple[Literal["number", "integer", "boolean", "choice", "text"], list[str] | None]:
    if typing.get_origin(annotation) is Literal:
        return "choice", [str(choice) for choice in typing.get_args(annotation)]
    if isinstance(annotation, types.UnionType):
        annotation = next(part for part in typing.get_args(annotation) if part is not type(None))
    return _KINDS.get(annotation, "text"), None


def _plain(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value
