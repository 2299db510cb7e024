"""Compares names of labels without case and punctuation, for dialogs, imports and comparisons."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

from pydantic import ValidationError

_LOOSE = re.compile(r"[\s_\-./,:;()'\"]+")
_BETWEEN_NUMBERS = re.compile(rf"(?<=\d){_LOOSE.pattern}(?=\d)")


@lru_cache(maxsize=2**16)
def comparable(name: str) -> str:
    """A name without case, spaces and punctuation, in Unicode's compatible form.

    ``"No parking"``, ``no_parking`` and ``NO-PARKING`` are equal. Adjacent numbers stay separate: ``3.5 t`` equals
    ``3,5t``, not ``35 t``. A name that is punctuation alone is returned unchanged.
    """
    folded = unicodedata.normalize("NFKC", name).casefold()
    return _LOOSE.sub("", _BETWEEN_NUMBERS.sub("|", folded)) or folded


@lru_cache(maxsize=2**16)
def words_of(name: str) -> str:
    """The words of a name without case and punctuation, in Unicode's compatible form, with a space around each."""
    words = _LOOSE.split(unicodedata.normalize("NFKC", name).casefold())
    return f" {' '.join(filter(None, words))} "


def first_problem(error: ValidationError) -> tuple[str, str]:
    """Place and rule of the first value that breaks a rule of the model, as part of a sentence."""
    first = error.errors(include_url=False, include_input=False, include_context=False)[0]
    place = ".".join(str(part) for part in first["loc"])
    return place, first["msg"].removeprefix("Value error, ").rstrip(".")
