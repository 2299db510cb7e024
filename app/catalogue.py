"""The classes with their pictograms, and every parameter with its range: what dialogs are built from."""

from __future__ import annotations

import threading
import types
import typing
from collections import OrderedDict
from typing import Any, Literal

import cv2
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from app.shapes import Model
from tsr_engine.params import PRESETS, Params
from tsr_engine.params.replayable import is_replayable
from tsr_engine.pictograms import draw
from tsr_engine.recognition.catalogue import CATALOGUE

__all__ = ["Label", "Parameter", "Pictograms", "labels", "parameters"]

_KINDS: dict[object, Literal["number", "integer", "boolean"]] = {bool: "boolean", int: "integer", float: "number"}


class Label(Model):
    """One class."""

    id: int
    name: str
    picture: str


class Parameter(Model):
    """See ``Parameter`` in static/js/types.js."""

    section: str
    name: str
    type: Literal["number", "integer", "boolean", "choice", "text"]
    default: bool | int | float | str | list[float] | None
    low: float | None
    high: float | None
    choices: list[str] | None
    description: str
    replayable: bool
    presets: dict[str, bool | int | float | str | list[float] | None]


class Pictograms:
    """The signs as PNG, drawn when first asked for."""

    def __init__(self, most: int = 172) -> None:
        self._most = most
        self._lock = threading.Lock()
        self._drawn: OrderedDict[tuple[int, int], bytes] = OrderedDict()

    def png(self, class_id: int, size: int) -> bytes:
        """One sign, ``size`` px square, transparent around it.

        Raises:
            KeyError: the class is not one of the 43.
            ValueError: the size is below 1.
        """
        key = class_id, size
        with self._lock:
            if key in self._drawn:
                self._drawn.move_to_end(key)
                return self._drawn[key]
        _, code = cv2.imencode(".png", draw(f"gtsrb/{class_id}", size), [cv2.IMWRITE_PNG_COMPRESSION, 9])
        content = code.tobytes()
        with self._lock:
            self._drawn[key] = content
            while len(self._drawn) > self._most:
                self._drawn.popitem(last=False)
        return content


def labels() -> list[Label]:
    """The 43 classes."""
    return [Label(id=sign.id, name=sign.name, picture=f"/api/labels/{sign.id}.png") for sign in CATALOGUE]


def parameters() -> list[Parameter]:
    """All parameters of the engine, in its own order."""
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


def _kind(annotation: Any) -> tuple[Literal["number", "integer", "boolean", "choice", "text"], list[str] | None]:
    if typing.get_origin(annotation) is Literal:
        return "choice", [str(choice) for choice in typing.get_args(annotation)]
    if isinstance(annotation, types.UnionType):
        annotation = next(part for part in typing.get_args(annotation) if part is not type(None))
    return _KINDS.get(annotation, "text"), None


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value
