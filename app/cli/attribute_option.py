"""``--attribute``: an attribute of a label, written on one line."""

from __future__ import annotations

import re
from typing import Final

from tsr_engine.errors import UsageError

ATTRIBUTE_HELP: Final = (
    "NAME:checkbox, NAME:text, NAME:select=A|B or NAME:number=LOW..HIGH, then ,mutable and ,default=VALUE; repeatable."
)
_FORM: Final = re.compile(
    r"(?P<name>[^:]+):(?P<kind>checkbox|select|number|text)"
    r"(?:=(?P<values>[^,]*))?(?P<mutable>,mutable)?(?:,default=(?P<default>.*))?"
)


def parse_attribute(text: str) -> dict[str, object]:
    """Parse the fields of an attribute; see ``Attribute`` in ``tsr_engine.labels.model``.

    Raises:
        UsageError: the text has another form.
    """
    found = _FORM.fullmatch(text)
    if found is None:
        raise _wrong(text)
    kind, values, default = found["kind"], found["values"], found["default"]
    facts: dict[str, object] = {"name": found["name"].strip(), "kind": kind, "mutable": found["mutable"] is not None}
    if kind == "select" and values:
        facts["values"] = [value.strip() for value in values.split("|")]
    elif kind == "number" and values:
        low, dots, high = values.partition("..")
        if not dots:
            raise _wrong(text)
        facts |= {"low": _number(low, text), "high": _number(high, text)}
    elif values is not None:
        raise _wrong(text)
    if default is not None:
        facts["default"] = _default(kind, default, text)
    return facts


def _default(kind: str, default: str, text: str) -> bool | float | str | None:
    if kind == "checkbox":
        if default not in ("true", "false"):
            raise _wrong(text)
        return default == "true"
    return _number(default, text) if kind == "number" else default


def _number(text: str, whole: str) -> float | None:
    try:
        return float(text) if text.strip() else None
    except ValueError:
        raise _wrong(whole) from None


def _wrong(text: str) -> UsageError:
    return UsageError(f"Expected --attribute as {ATTRIBUTE_HELP.removesuffix('; repeatable.')}. Got {text!r}.")
