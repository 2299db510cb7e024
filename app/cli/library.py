"""A library for commands that work on its database without a server; safe beside a running one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tsr_engine.errors import UsageError

if TYPE_CHECKING:
    from app.settings import Settings
    from app.storage.database import Database

__all__ = ["HomeOption", "opened_library"]

HomeOption = Annotated[
    Path | None, typer.Option("--home", metavar="DIR", help="Data folder of 'tsr review'.", show_default=False)
]


@contextmanager
def opened_library(home: Path | None) -> Iterator[tuple[Settings, Database]]:
    """The settings and the database of a data folder that is there; refusals become errors of the command line.

    Raises:
        UsageError: there is no such folder, or what is done in the block is refused.
    """
    from app.errors import ApiError
    from app.settings import DATABASE_FILE, load_settings, no_home
    from app.storage.identity import database_of

    settings = load_settings(home=home)
    if settings.database_url is None and not (settings.home / DATABASE_FILE).is_file():
        raise UsageError(no_home(settings.home))
    database = database_of(settings)
    try:
        database.migrate(settings.home / "backups")
        yield settings, database
    except ApiError as error:
        raise UsageError(error.message) from None
    finally:
        database.close()
