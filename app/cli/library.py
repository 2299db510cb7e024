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

HomeOption = Annotated[
    Path | None, typer.Option("--home", metavar="DIR", help="Data folder of 'tsr review'.", show_default=False)
]


@contextmanager
def open_library(home: Path | None) -> Iterator[tuple[Settings, Database]]:
    """Open the settings and the database of an existing data folder; refusals become errors of the command line.

    Raises:
        InputError: there is no such folder.
        UsageError: an operation in the block is refused.
    """
    from app.cli.data_folder import open_home
    from app.errors import ApiError

    try:
        with open_home(home) as opened:
            yield opened
    except ApiError as error:
        raise UsageError(error.message) from None
