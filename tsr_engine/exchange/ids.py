"""Reads ids and numbers in other tools' JSON, in which pandas may have made ``11`` into ``11.0`` or ``"11"``."""

from __future__ import annotations

import re
from typing import Final, TypeGuard

from tsr_engine.exchange.reading import rule_error
from tsr_engine.io.plain_numbers import parse_real

_WHOLE: Final = re.compile(r"(0|-?[1-9][0-9]{0,17})(?:\.0+)?")

WHOLE_ID: Final = re.compile(r"[0-9]{1,20}")
"""A track id in the text of a table."""
_NO_TRACK: Final = frozenset({"", "nan", "none", "null"})
"""Values for a missing id in tables."""


def is_number(value: object) -> TypeGuard[float]:
    """Whether a JSON value is a number; ``true`` is not."""
    return type(value) in (int, float)


def id_of(value: object) -> int | str | None:
    """An id; a whole number becomes an ``int`` in any notation. None: it is not an id, such as 11.5."""
    if type(value) is int:
        return value
    if isinstance(value, float):
        return int(value) if value.is_integer() else None
    if isinstance(value, str):
        found = _WHOLE.fullmatch(value)
        return int(found[1]) if found else value
    return None


def track_of(value: object, what: str, file: str, where: str) -> int | str | None:
    """The id of a track; None: the file states none.

    Raises:
        ImportFormatError: it is not an id, such as 11.5.
    """
    if value is None or (isinstance(value, str) and value.strip().lower() in _NO_TRACK):
        return None
    found = id_of(value)
    if found is None:
        raise rule_error(file, where, f"{what} must be a whole number. Got {str(value)[:40]!r}. Correct it.")
    return None if found == -1 else found


def whole_of(value: object, what: str, file: str, where: str) -> int:
    """A whole number from JSON.

    Raises:
        ImportFormatError: it is not a whole number.
    """
    found = id_of(value)
    if isinstance(found, int):
        return found
    raise rule_error(file, where, f"{what} must be a whole number. Got {str(value)[:40]!r}.")


def real_of(value: object, what: str, file: str, where: str, *, in_text: bool = False) -> float:
    """A number from JSON, which may be infinite.

    Args:
        value: as in the file.
        what: name of the value, for messages.
        file: for messages.
        where: place in the file.
        in_text: whether it may stand in quotes, as CVAT's attributes do after some tools.

    Raises:
        ImportFormatError: it is not a number, or is too large.
    """
    if in_text and isinstance(value, str):
        try:
            return parse_real(value)
        except ValueError:
            pass
    if not is_number(value):
        description = "null or NaN" if value is None else repr(str(value)[:40])
        raise rule_error(file, where, f"{what} must be a finite number. Got {description}.")
    try:
        return float(value)
    except OverflowError:
        raise rule_error(file, where, f"{what} is too large. Correct it.") from None
