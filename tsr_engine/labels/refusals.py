"""Errors about changes of a label set, and the check whether another label has a word already."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from tsr_engine.errors import InputError
from tsr_engine.labels.model import Label
from tsr_engine.labels.wording import comparable

__all__ = ["ChangeError", "NoLabelError", "TakenError", "claims_of", "require_free", "require_unclaimed"]


class ChangeError(InputError):
    """A change that breaks a rule of label sets.

    Attributes:
        field: of the change; None: it is about the whole change.
    """

    def __init__(self, message: str, field: str | None = None) -> None:
        super().__init__(message)
        self.field = field


class NoLabelError(ChangeError):
    """The change is about a label that the set does not have."""


class TakenError(ChangeError):
    """Another label has the key, the name, the alias or the digit already.

    Attributes:
        label: that label.
    """

    def __init__(self, message: str, field: str, label: Label) -> None:
        super().__init__(message, field)
        self.label = label


def require_free(label: Label, others: Iterable[Label], claims: Mapping[str, Label] | None = None) -> None:
    """Refuse a label whose key, words or digit another label has.

    Args:
        label: as it shall be.
        others: labels of the set; the label itself may be among them, as it was.
        claims: of the other labels, where they are known.

    Raises:
        TakenError: says which label has what.
    """
    others = [other for other in others if other.id != label.id]
    claims = claims_of(others) if claims is None else claims
    for other in others:
        if other.key.casefold() == label.key.casefold():
            raise _taken(label.key, "key", other)
    for word, field in ((label.key, "key"), (label.name, "name"), *((alias, "aliases") for alias in label.aliases)):
        require_unclaimed(claims, word, field)
    for other in others:
        if label.pinned is not None and other.pinned == label.pinned:
            raise TakenError(
                f"The digit {label.pinned} is that of '{other.name}' (label {other.id}). Take it off there first.",
                "pinned",
                other,
            )


def claims_of(labels: Iterable[Label]) -> dict[str, Label]:
    """Comparable word -> the label that it belongs to; words of merged labels are free."""
    claims: dict[str, Label] = {}
    for label in labels:
        if label.merged_into is None:
            for word in (label.key, label.name, *label.aliases):
                claims.setdefault(comparable(word), label)
    return claims


def require_unclaimed(claims: Mapping[str, Label], word: str, field: str) -> None:
    """Refuse a word that another label has.

    Raises:
        TakenError: says which.
    """
    other = claims.get(comparable(word))
    if other is not None:
        raise _taken(word, field, other)


def _taken(word: str, field: str, other: Label) -> TakenError:
    state = "merged into another" if other.merged_into is not None else "hidden" if other.hidden else ""
    also = f", {state}" if state else ""
    what = {"key": "key", "name": "name", "aliases": "alias"}[field]
    return TakenError(
        f"The {what} '{word}' belongs to '{other.name}' (label {other.id}, key {other.key}{also}).", field, other
    )
