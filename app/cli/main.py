"""The command ``tsr``: the engine's commands and ``review``."""

from __future__ import annotations

from app.cli.review import review
from tsr_engine.cli import main as engine

__all__ = ["run"]


def run(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    known = {command.name for command in engine.app.registered_commands}
    if "review" not in known:
        engine.app.command("review")(review)
    return engine.run(arguments)
