"""Databases that earlier versions put beside the data folder, because its name contains ``?`` or ``%``.

Those versions wrote the folder into an address as text, where both characters have a meaning. Two folders could share
one file, so it is copied and stays where it is.
"""

from __future__ import annotations

import logging
import sqlite3
from contextlib import closing
from pathlib import Path

from sqlalchemy import make_url

from app.settings import DATABASE_FILE, Settings

_log = logging.getLogger("tsr.server")


def fetch_misplaced(settings: Settings) -> None:
    """Copy the database of an existing data folder into it, if it lies elsewhere."""
    database_file = settings.home / DATABASE_FILE
    if settings.database_url is not None or database_file.exists() or not (settings.home / "token").is_file():
        return
    earlier = Path(make_url(f"sqlite:///{database_file}").database or "")
    truncated = Path(f"{database_file}".partition("?")[0])
    misplaced = next((file for file in (earlier, truncated) if file != database_file and file.is_file()), None)
    if misplaced is None:
        return
    part = database_file.with_suffix(".part")
    part.unlink(missing_ok=True)
    try:
        with closing(sqlite3.connect(misplaced)) as source, closing(sqlite3.connect(part)) as copy:
            source.execute("SELECT version_num FROM alembic_version").fetchone()
            source.backup(copy)
    except sqlite3.DatabaseError:
        part.unlink(missing_ok=True)
        return  # not a database of tsr
    part.replace(database_file)
    _log.warning("The database of %s lay at %s; it was copied into the data folder.", settings.home, misplaced)
