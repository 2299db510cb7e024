"""Migrates the tables with Alembic, after copying a SQLite file."""

from __future__ import annotations

import shutil
import sqlite3
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Engine
from sqlalchemy.exc import DBAPIError

from tsr_engine.errors import StorageError

MIGRATIONS = Path(__file__).parent / "migrations"


def migrate_tables(engine: Engine, backup: Path | None = None) -> None:
    """Create or change the tables of a database.

    Args:
        engine: its connections may write.
        backup: folder to which the SQLite file is copied before an existing database changes.

    Raises:
        StorageError: the database is newer than this version, damaged, in use, or cannot be changed.
    """
    try:
        _upgrade(engine, backup)
    except DBAPIError as error:
        raise _storage_error(engine, backup, error.orig) from None
    except sqlite3.Error as error:
        raise _storage_error(engine, backup, error) from None


def _config() -> Config:
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))  # no interpolation
    return config


@cache
def _scripts() -> ScriptDirectory:
    """All migrations, loaded once a process."""
    return ScriptDirectory.from_config(_config())


def _upgrade(engine: Engine, backup: Path | None) -> None:
    scripts = _scripts()
    with engine.connect() as connection:
        revision = MigrationContext.configure(connection).get_current_revision()
        connection.rollback()
        if revision == scripts.get_current_head():
            return
        known = {script.revision for script in scripts.walk_revisions()}
        if revision is not None and revision not in known:
            other = "data folder with --home" if engine.dialect.name == "sqlite" else "database with --database"
            raise StorageError(
                f"The database was written by a newer version of tsr (tables {revision}). Install that version, "
                f"restore a backup of this version, or name another {other}."
            )
        if revision is not None and backup is not None:
            back_up(engine, backup)
        config = _config()
        config.attributes["connection"] = connection
        command.upgrade(config, "head")
        connection.commit()


def _storage_error(engine: Engine, backup: Path | None, cause: BaseException | None) -> StorageError:
    """Convert the driver's error to a sentence that says what to do."""
    reason = (str(cause).strip().splitlines() or [type(cause).__name__])[0].rstrip(".")
    if engine.dialect.name != "sqlite":
        return StorageError(f"The database cannot be used: {reason}. Check that it runs, and its address (--database).")
    file = engine.url.database
    if isinstance(cause, sqlite3.OperationalError):  # locked, no permission, or a full disk
        return StorageError(
            f"The database {file} cannot be used: {reason}. Check the disk, and which programs use the file."
        )
    copy = "" if backup is None else f" and restore a copy from {backup}"
    return StorageError(
        f"The database {file} is damaged or not one of tsr: {reason}. Move it away{copy}, or name another data folder "
        "with --home."
    )


def back_up(engine: Engine, folder: Path) -> None:
    """Copy the file of a SQLite database to a folder.

    Raises:
        StorageError: there is no room for the copy.
    """
    name = engine.url.database
    assert name is not None
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / f"{Path(name).stem}-{datetime.now(UTC):%Y%m%dT%H%M%S}.sqlite"
    if shutil.disk_usage(folder).free < 2 * Path(name).stat().st_size:
        raise StorageError(f"There is no space in {folder} to copy {name} before its tables change. Free some.")
    with sqlite3.connect(name) as source, sqlite3.connect(target) as copy:
        source.backup(copy)
    copy.close()
    source.close()
