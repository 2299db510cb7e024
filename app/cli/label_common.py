"""What the commands of ``tsr labels`` share: options, the service, and look-up of labels by name."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.library import open_library
from tsr_engine.cli.common import print_json, say
from tsr_engine.errors import UsageError

if TYPE_CHECKING:
    from app.labels.service import LabelService
    from tsr_engine.labels.model import Label, LabelSet

SetOption = Annotated[
    str | None,
    typer.Option("--set", metavar="KEY", help="Label set.  [default: that of the library]", show_default=False),
]
LabelArgument = Annotated[str, typer.Argument(metavar="LABEL", help="Key, name or alias of a label, or #14.")]
FormatOption = Annotated[
    str | None, typer.Option("--format", help="tsr, cvat, names, yaml, coco or label-studio.", show_default=False)
]


@contextmanager
def label_service(home: Path | None) -> Iterator[tuple[LabelService, str]]:
    """Open the label sets of a data folder; yields the service and the author of changes."""
    from app.events import EventBus
    from app.labels.service import LabelService

    with open_library(home) as (settings, database):
        yield LabelService(database, EventBus()), settings.author


def change_labels(service: LabelService, key: str | None, author: str, change: dict[str, object], json: bool) -> None:
    """Apply a change in the form in which the page sends it, and print what it did."""
    from pydantic import TypeAdapter, ValidationError

    from app.labels.commands import LabelChange
    from tsr_engine.labels.name_matching import first_problem

    try:
        command: LabelChange = TypeAdapter(LabelChange).validate_python(change)
    except ValidationError as error:
        place, problem = first_problem(error)
        raise UsageError(f"{place.removeprefix(str(change['type']) + '.')}: {problem}.") from None
    done = service.change(service.get(key).key, author, command)
    if json:
        print_json(done.model_dump(mode="json"))
    else:
        label = "" if done.label is None else f" It is label {done.label.id}, key {done.label.key}."
        say(f"{done.sentence}{label}")


def find_label(labels: LabelSet, word: str) -> Label:
    """Find a label by key, name, alias or ``#number``.

    Raises:
        UsageError: there is none.
    """
    from tsr_engine.labels.matching import LabelFinder, unknown_label

    found = LabelFinder(labels).find(word)
    if found is None:
        raise UsageError(unknown_label(word, labels))
    return found.label


def parse_set_key(key: str) -> str:
    """Check the key of a label set.

    Raises:
        UsageError: a set cannot have that key.
    """
    from app.labels.store import SET_KEY

    if not re.fullmatch(SET_KEY, key):
        raise UsageError(f"Expected the key of a label set: small letters, digits, '.', '-' and '_'. Got {key!r}.")
    return key


def written(value: object) -> str:
    """Format a value of an answer for people."""
    if isinstance(value, list):
        return "; ".join(written(each) for each in value)
    if isinstance(value, dict):
        return ", ".join(f"{name} {written(each)}" for name, each in value.items() if each not in (None, [], False))
    return str(value)
