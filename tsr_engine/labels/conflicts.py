"""Defines errors about changes of a label set, and checks whether a word is taken."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from tsr_engine.errors import InputError
from tsr_engine.labels.model import Label
from tsr_engine.labels.name_matching import comparable


class ChangeError(InputError):
    """Raised if a change breaks a rule of label sets.

    Attributes:
        field: field of the change; None: the whole change.
    """

    def __init__(self, message: str, field: str | None = None) -> None:
        super().__init__(message)
        self.field = field


class NoLabelError(ChangeError):
    """Raised if the set does not have the label of a change."""


class TakenError(ChangeError):
    """Raised if another label has the key, the name, the alias or the digit.

    Attributes:
        label: that label.
    """

    def __init__(self, message: str, field: str, label: Label) -> None:
        super().__init__(message, field)
        self.label = label


def require_free(label: Label, others: Iterable[Label], claims: Mapping[str, Label] | None = None) -> None:
    """Refuse a label whose key, words or digit another label has.

    Args:
        label: the label after the change.
        others: labels of the set, possibly with the label's old version.
        claims: words of the other labels, if known.

    Raises:
        TakenError: names the label and the word.
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
                f"The digit {label.pinned} belongs to '{other.name}' (label {other.id}). Remove it there first.",
                "pinned",
                other,
            )


def claims_of(labels: Iterable[Label]) -> dict[str, Label]:
    """Comparable word -> its label; words of merged labels are free."""
    claims: dict[str, Label] = {}
    for label in labels:
        if label.merged_into is None:
            for word in label.words:
                claims.setdefault(comparable(word), label)
    return claims


def require_unclaimed(claims: Mapping[str, Label], word: str, field: str) -> None:
    """Refuse a word that another label has.

    Raises:
        TakenError: names the label.
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
