"""Finds the label for a word, for dialogs, imports, comparisons and the command line."""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass
from typing import Literal

from tsr_engine.labels.model import Label, LabelSet
from tsr_engine.labels.name_matching import comparable, words_of

How = Literal["key", "name", "alias", "short", "number"]
_NUMBER = re.compile(r"(?:#|(?:class|label|id|c)[\s_:#-]*)?0*(\d{1,9})", re.ASCII | re.IGNORECASE)
_MIN_SIMILARITY = 0.75
"""Least similarity of a suggestion, 0 to 1: that of a word of four letters of which two are swapped."""
_MAX_SUGGESTIONS = 3
_SEE_LABELS = "The page Labels and 'tsr labels list' list the labels."
"""Where people find what labels are called."""


@dataclass(frozen=True, slots=True)
class Match:
    """A label, and which of its words matched."""

    label: Label
    how: How


@dataclass(frozen=True, slots=True)
class Suggestions:
    """Labels that a word may mean.

    Attributes:
        labels: the most likely first.
        similar: whether they resemble the word; else they only contain it.
    """

    labels: tuple[Label, ...]
    similar: bool


class LabelFinder:
    """Finds labels of one set by word; built once, used often.

    The order is: key; name; alias; short name, unless it is a number; id, such as ``14``, ``00014``,
    ``class 14``, ``#14``. Spaces, case and punctuation do not matter. A merged label gives its target; hidden labels
    are found.
    """

    def __init__(self, labels: LabelSet) -> None:
        """Take a set."""
        self._by_id = {label.id: label for label in labels}
        self._words: dict[str, Match] = {}
        live = [label for label in labels if label.merged_into is None]
        merged = [label for label in labels if label.merged_into is not None]
        self._live = live
        self._into = labels.merged_ids()
        for group in (live, merged):
            for how in ("key", "name", "alias", "short"):
                for label in group:
                    target = self._by_id[self._into.get(label.id, label.id)]
                    for word in _words(label, how):
                        self._words.setdefault(comparable(word), Match(target, how))

    def find(self, word: str) -> Match | None:
        """The label for a word; None: no label matches."""
        return self.named(word) or self.numbered(word)

    def numbered(self, word: str) -> Match | None:
        """The label for an id, such as ``14``, ``00014``, ``class 14``, ``#14``; None: no label has it."""
        number = _NUMBER.fullmatch(word.strip())
        if number is None:
            return None
        label = self._by_id.get(self._into.get(int(number[1]), int(number[1])))
        return None if label is None else Match(label, "number")

    def named(self, word: str) -> Match | None:
        """As :meth:`find`, but numbers are not ids."""
        return self._words.get(comparable(word))

    def with_words(self, text: str) -> list[Label]:
        """Labels with a key, a name or an alias that has all words of a text, in the order of the set.

        A word may be the beginning of one, unless it is a number. A merged label gives its target.
        """
        wanted = [f" {word} " if word.isdecimal() else f" {word}" for word in words_of(text).split()]
        if not wanted:
            return []
        found = {
            self._into.get(label.id, label.id)
            for label in self._by_id.values()
            for known in label.words
            if wanted[0] in (words := words_of(known)) and all(word in words for word in wanted)
        }
        return [label for label in self._live if label.id in found]

    def suggestions(self, word: str) -> Suggestions:
        """Labels that a word may mean: those that resemble it, else those that contain it."""
        similar = self.similar(word)
        return Suggestions(tuple(similar or self.containing(word)), bool(similar))

    def containing(self, word: str) -> list[Label]:
        """Labels as in :meth:`with_words`, then those with the word's letters anywhere; a letter alone gives none."""
        letters = comparable(word)
        if len(letters) < 2:
            return []
        anywhere = [match.label for known, match in self._words.items() if letters in known]
        found = {label.id: label for label in (*self.with_words(word), *anywhere)}
        return [*found.values()][:_MAX_SUGGESTIONS]

    def similar(self, word: str) -> list[Label]:
        """Labels whose name, key or alias resembles a word, the most similar first.

        For a number: labels with it in their name, then the label with that id.
        """
        if (number := _NUMBER.fullmatch(word.strip())) is not None:
            return self._numbered(number[1])[:_MAX_SUGGESTIONS]
        wanted, scores = comparable(word), dict[int, float]()
        matcher = difflib.SequenceMatcher(autojunk=False)
        matcher.set_seq2(wanted)
        for known, match in self._words.items():
            matcher.set_seq1(known)
            if matcher.real_quick_ratio() < _MIN_SIMILARITY or matcher.quick_ratio() < _MIN_SIMILARITY:
                continue
            scores[match.label.id] = max(scores.get(match.label.id, 0.0), matcher.ratio())
        best = sorted((-score, number) for number, score in scores.items() if score >= _MIN_SIMILARITY)
        return [self._by_id[number] for _, number in best[:_MAX_SUGGESTIONS]]

    def _numbered(self, digits: str) -> list[Label]:
        number = re.compile(rf"(?<![\d.,]){digits}(?![.,]?\d)")
        found = [label for label in self._live if not label.hidden and number.search(label.name)]
        of_id = self._by_id.get(self._into.get(int(digits), int(digits)))
        return found if of_id is None or of_id in found else [*found, of_id]


def unknown_label(word: str, *sets: LabelSet) -> str:
    """The message that refuses a word which no label of some label sets has; it proposes labels that resemble it."""
    similar = dict.fromkeys(label.name for labels in sets for label in LabelFinder(labels).suggestions(word).labels)
    hint = f"Is it {', '.join(map(repr, [*similar][:_MAX_SUGGESTIONS]))}?" if similar else _SEE_LABELS
    place = "label set" if len(sets) == 1 else "label sets"
    return (
        f"No label of the {place} {', '.join(repr(labels.name) for labels in sets)} has the key, name, alias or number "
        f"{word!r}. {hint}"
    )


def _words(label: Label, how: str) -> tuple[str, ...]:
    if how == "key":
        return (label.key,)
    if how == "name":
        return (label.name,)
    if how == "alias":
        return label.aliases
    # Short names are words for most signs, but numbers are ids in other tools.
    return () if not label.short or label.short.isdigit() else (label.short,)
