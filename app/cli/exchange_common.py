"""Options and messages that ``tsr export`` and ``tsr import`` share."""

from __future__ import annotations

from typing import Annotated

import typer

from tsr_engine.cli.common import out_console
from tsr_engine.errors import UsageError

OptionOption = Annotated[
    list[str], typer.Option("--option", metavar="NAME=VALUE", help="An option of the format; repeatable.")
]


def print_lines(lines: list[str], limit: int = 12) -> None:
    """Print the first lines of a list, and how many more there are."""
    console = out_console()
    for line in lines[:limit]:
        console.print(line, soft_wrap=True, markup=False)
    if len(lines) > limit:
        console.print(f"... and {len(lines) - limit} more; --json lists all.", soft_wrap=True)


def pairs(option: str, texts: list[str]) -> dict[str, str]:
    """Parse the values of a repeatable option NAME=VALUE.

    Raises:
        UsageError: a value has another form.
    """
    found: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise UsageError(f"{option} expects NAME=VALUE. Got '{text}' instead.")
        found[name.strip()] = value.strip()
    return found
