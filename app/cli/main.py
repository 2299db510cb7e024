"""The command ``tsr``: the engine's commands and ``review``."""

from __future__ import annotations

from app.cli.bundle import bundle
from app.cli.check import check
from app.cli.export import export, formats
from app.cli.import_file import import_file
from app.cli.labels import app as labels
from app.cli.models import app as models
from app.cli.people import app as people
from app.cli.record import record
from app.cli.review import review
from app.cli.search import search
from tsr_engine.cli import main as engine
from tsr_engine.cli.common import ParameterCommand


def register() -> None:
    """Add the commands of the review tool to the engine's; a second call changes nothing."""
    known = {command.name for command in engine.app.registered_commands}
    if "review" not in known:
        engine.app.command("review")(review)
        engine.app.command("export")(export)
        engine.app.command("import")(import_file)
        engine.app.command("formats")(formats)
        engine.app.command("bundle")(bundle)
        engine.app.command("check", cls=ParameterCommand)(check)
        engine.app.add_typer(models, name="models")
        engine.app.add_typer(labels, name="labels")
        engine.app.add_typer(people, name="people")
        engine.app.command("record")(record)
        engine.app.command("search")(search)
        engine.command.cache_clear()


def run(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    register()
    return engine.run(arguments)
