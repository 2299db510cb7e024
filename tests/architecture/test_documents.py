"""README and docs name what the command line offers."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest
import typer.main

from app.cli.main import register
from tsr_engine.cli.main import app

register()
ROOT = Path(__file__).resolve().parents[2]


def commands() -> list[str]:
    """Every command with its group: ``track``, ``eval tracking``, ..."""
    names: list[str] = []
    for name, command in typer.main.get_command(app).commands.items():  # type: ignore[attr-defined]
        inner = getattr(command, "commands", None)
        names += [name] if inner is None else [f"{name} {leaf}" for leaf in inner]
    return sorted(names)


def test_the_readme_names_every_command_group() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    missing = sorted({name.split()[0] for name in commands()} - _after_tsr(text))
    assert not missing, f"README.md does not show `tsr {missing[0]}`"


@pytest.mark.parametrize("name", commands())
def test_readme_and_docs_together_name_every_command(name: str) -> None:
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))]
    group, _, leaf = name.partition(" ")
    lines = [line for text in texts for line in text.splitlines() if f"tsr {group}" in line]
    assert any(not leaf or leaf in line for line in lines), f"neither README.md nor docs/ show `tsr {name}`"


def _after_tsr(text: str) -> set[str]:
    """The words that follow ``tsr`` anywhere."""
    words = text.replace("`", " ").split()
    return {after for word, after in itertools.pairwise(words) if word == "tsr"}
