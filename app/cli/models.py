"""``tsr models``: the versions of a data folder, without a server."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.library import HomeOption, open_library
from tsr_engine.cli.common import JsonOption, out_console, print_json, say
from tsr_engine.errors import UsageError

if TYPE_CHECKING:
    from app.training.service import TrainingService
    from app.training.view import ModelView

app = typer.Typer(
    help="List the model versions of a data folder, promote one, or roll back.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.command("list")
def listed(home: HomeOption = None, json: JsonOption = False) -> None:
    """List all versions with their figures on held-out corrections; a star marks the one that new runs use.

    \b
    Example:
      tsr models list --home out/review
    """
    with _service(home) as service:
        views, active = service.list()
    if json:
        print_json({"models": [view.model_dump(mode="json") for view in views], "active": active})
        return
    from rich.table import Table

    table = Table("", "id", "name", "state", "from", "held-out AP, before and after", box=None, pad_edge=False)
    for view in views:
        found = view.figures.get("corrections", {})
        before, after = (found.get(side, {}).get("ap50") for side in ("parent", "new"))
        figures = f"{before:.4f} {after:.4f}" if before is not None and after is not None else ""
        parent = "" if view.id == "shipped" else (view.parent_id or "shipped")
        table.add_row("*" if view.active else "", view.id, view.name, view.state, parent, figures)
    out_console().print(table)


@app.command("promote")
def promote(
    version: Annotated[str, typer.Argument(help="Id or name of a version, or 'shipped'.")], home: HomeOption = None
) -> None:
    """Let new runs use a version.

    \b
    Example:
      tsr models promote "Version 2" --home out/review
    """
    with _service(home) as service:
        now = service.promote(_named(service, version))
    say(f"New runs use {now.name}.")


@app.command("rollback")
def rollback(home: HomeOption = None) -> None:
    """Undo the last promotion.

    \b
    Example:
      tsr models rollback --home out/review
    """
    with _service(home) as service:
        now = service.rollback()
    say(f"New runs use {now.name}.")


@contextmanager
def _service(home: Path | None) -> Iterator[TrainingService]:
    """Open the service on an existing data folder; its refusals become errors of the command line."""
    from app.events import EventBus
    from app.job_kinds import KINDS
    from app.jobs.queue import JobQueue
    from app.training.service import TrainingService

    with open_library(home) as (settings, database):
        events = EventBus()
        yield TrainingService(settings, database, events, JobQueue(events, KINDS))


def _named(service: TrainingService, text: str) -> str:
    """The id of a version by its id, its name, or the start of its id."""
    views: list[ModelView] = service.list()[0]
    found = [view.id for view in views if text == view.id]  # a version may have the name ``shipped``
    found = found or [view.id for view in views if text == view.name]
    found = found or [view.id for view in views if len(text) >= 6 and view.id.startswith(text)]
    if len(found) != 1:
        many = "several versions are called" if found else "there is no version"
        raise UsageError(f"Expected the id or name of one version: {many} {text!r}. See 'tsr models list'.")
    return found[0]
