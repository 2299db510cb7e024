"""Every command has one line in the list of commands."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
import typer

from app.cli.main import register
from tsr_engine.cli.main import app


def commands() -> dict[str, Any]:
    """All commands and groups, those of the review tool too, by name."""

    def walk(name: str, command: Any) -> Iterator[tuple[str, Any]]:
        yield name, command
        for word, inner in getattr(command, "commands", {}).items():
            yield from walk(f"{name} {word}", inner)

    register()
    return dict(walk("tsr", typer.main.get_command(app)))


COMMANDS = commands()


def test_every_command_is_checked() -> None:
    assert {"tsr track", "tsr export", "tsr models list", "tsr train lambda", "tsr eval fusion"} <= COMMANDS.keys()


@pytest.mark.parametrize("name", COMMANDS)
def test_the_line_of_a_command_is_a_complete_sentence(name: str) -> None:
    """The list shows the help up to its first full stop, which may belong to an abbreviation."""
    line = COMMANDS[name].get_short_help_str(limit=10_000)
    assert line.endswith(".")
    assert not line.endswith(("...", "Eq.", "e.g.", "i.e.", "etc."))
    assert line.count("(") == line.count(")")
