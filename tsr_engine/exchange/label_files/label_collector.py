"""Collects the labels of a file as a label set of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from tsr_engine.exchange.reading import rule_error
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.changes import key_of
from tsr_engine.labels.model import MAX_LABELS, Attribute, Label, LabelSet
from tsr_engine.labels.name_matching import comparable, first_problem

_MAX_NUMBER = 2**31 - 1


@dataclass(frozen=True, slots=True)
class RefusedName:
    """A name in the file that cannot be a label, with the reason."""

    name: str
    reason: str


@dataclass(frozen=True, slots=True)
class FileLabels:
    """The labels of a file.

    Attributes:
        labels: a label set; ids are the file's numbers if it has them, else the order.
        refused: names that cannot be labels.
        reported: sentences about what a set cannot hold.
    """

    labels: LabelSet
    refused: tuple[RefusedName, ...] = ()
    reported: tuple[str, ...] = ()


class LabelCollector:
    """Takes the labels of a file one by one."""

    def __init__(self, file: str) -> None:
        """Take the file's name, for messages."""
        self.file = file
        self._labels: list[Label] = []
        self._refused: list[RefusedName] = []
        self._reported: list[str] = []
        self._names: dict[str, str] = {}
        self._ids: dict[int, str] = {}
        self._digits: set[int] = set()

    def note(self, message: str) -> None:
        """Report a sentence once."""
        if message not in self._reported:
            self._reported.append(message)

    def attribute(self, label: str, fields: JsonObject) -> Attribute | None:
        """Make an attribute; None: it is invalid, which is reported."""
        try:
            return Attribute(**fields)
        except ValidationError as error:
            place, problem = first_problem(error)
            where = f"{place}: " if place else ""
            self.note(f"{self.file}, label {label!r}: an attribute was left out: {where}{problem}.")
            return None

    # Any: pydantic checks these fields of a label
    def add(self, name: str, where: str | int | None, number: int | None = None, **fields: Any) -> None:
        """Add a label.

        Args:
            name: as in the file.
            where: line or place, for messages.
            number: in the file; None: number the labels in their order.
            fields: further fields of :class:`Label`.

        Raises:
            ImportFormatError: two labels have the same number, or there are too many.
        """
        if len(self._labels) == MAX_LABELS:
            raise rule_error(
                self.file, where, f"is more than the {MAX_LABELS} labels that a set holds. Split the file."
            )
        name = name.strip()
        if number is not None and not 0 <= number <= _MAX_NUMBER:
            raise rule_error(self.file, where, f"the number of a label must be 0 to {_MAX_NUMBER}. Got {number}.")
        if number is not None and number in self._ids:
            raise rule_error(
                self.file, where, f"{name!r} has the number {number} of {self._ids[number]!r}. Correct one."
            )
        other = self._names.get(comparable(name))
        if other is not None:
            same = "occurs twice" if other == name else f"is the same label as {other!r} here"
            self._refused.append(RefusedName(name, f"{self._location(where)} {name!r} {same}."))
            return
        fields["aliases"] = self._free_aliases(name, fields.get("aliases", ()))
        fields["pinned"] = self._free_digit(name, fields.get("pinned"))
        label_id = len(self._labels) if number is None else number
        try:
            label = Label(id=label_id, key=key_of(name), name=name, **fields)
        except ValidationError as error:
            place, problem = first_problem(error)
            self._refused.append(RefusedName(name, f"{self._location(where)} {place or 'it'}: {problem}."))
            return
        if number is not None:
            self._ids[number] = name
        for word in (name, *label.aliases):
            self._names[comparable(word)] = name
        self._labels.append(label)

    def finish(self, key: str, name: str) -> FileLabels:
        """Return all labels.

        Args:
            key: key of the new set.
            name: name of the new set.

        Raises:
            ImportFormatError: the file has no labels.
        """
        if not self._labels and not self._refused:
            raise rule_error(self.file, None, "has no labels.")
        labels = [self._with_free_key(label) for label in self._labels]
        next_id = max((label.id for label in labels), default=-1) + 1
        label_set = LabelSet(key=key, name=name, next_id=next_id, labels=tuple(labels))
        return FileLabels(label_set, tuple(self._refused), tuple(self._reported))

    def _with_free_key(self, label: Label) -> Label:
        """The label with a key that is not a word of another label."""
        key = key_of(label.name, lambda key: self._names.get(comparable(key), label.name) != label.name)
        self._names[comparable(key)] = label.name
        return label.model_copy(update={"key": key})

    def _free_aliases(self, name: str, aliases: tuple[str, ...]) -> tuple[str, ...]:
        free: list[str] = []
        for alias in map(str.strip, aliases):
            other = self._names.get(comparable(alias))
            if other is not None:
                self.note(f"{self.file}: the alias {alias!r} of {name!r} was left out: {other!r} has it.")
            elif alias and comparable(alias) != comparable(name):
                free.append(alias)
        return tuple(free)

    def _free_digit(self, name: str, digit: int | None) -> int | None:
        if digit in self._digits:
            self.note(f"{self.file}: the key {digit} of {name!r} was left out: another label has it.")
            return None
        if digit is not None:
            self._digits.add(digit)
        return digit

    def _location(self, where: str | int | None) -> str:
        place = f"line {where}" if isinstance(where, int) else where
        return f"{self.file}, {place}:" if place else f"{self.file}:"
