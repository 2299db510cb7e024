"""A table of all parameters for display."""

from __future__ import annotations

from typing import Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from tsr_engine.json_shapes import JsonObject
from tsr_engine.params import Params


def parameter_rows(preset: str = "default") -> list[JsonObject]:
    """One row for each parameter: ``section``, ``name``, ``default``, ``value``, ``range``, ``description``.

    ``value`` is the preset's value.

    Raises:
        UsageError: the preset is unknown.
    """
    defaults, chosen = Params().model_dump(mode="json"), Params.preset(preset).model_dump(mode="json")
    rows = []
    for section, name in Params.names():
        field = type(getattr(Params(), section)).model_fields[name]
        rows.append(
            {
                "section": section,
                "name": name,
                "default": defaults[section][name],
                "value": chosen[section][name],
                "range": _range(field),
                "description": field.description or "",
            }
        )
    return rows


def _range(field: FieldInfo) -> str:
    """The allowed values of a field: choices, or an interval such as ``[0, 1]`` or ``(0, inf)``."""
    choices = _choices(field.annotation)
    if choices:
        return " | ".join(choices)
    low, high, low_open, high_open = "-inf", "inf", True, True
    for bound in field.metadata:
        if getattr(bound, "gt", None) is not None:
            low, low_open = f"{bound.gt:g}", True
        if getattr(bound, "ge", None) is not None:
            low, low_open = f"{bound.ge:g}", False
        if getattr(bound, "lt", None) is not None:
            high, high_open = f"{bound.lt:g}", True
        if getattr(bound, "le", None) is not None:
            high, high_open = f"{bound.le:g}", False
    if low == "-inf" and high == "inf":
        return ""
    return f"{'(' if low_open else '['}{low}, {high}{')' if high_open else ']'}"


def _choices(annotation: object) -> list[str]:
    if annotation is bool:
        return ["true", "false"]
    if get_origin(annotation) is Literal:
        return [str(value) for value in get_args(annotation)]
    return []
