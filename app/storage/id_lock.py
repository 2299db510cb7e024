"""Ensures that only one server at a time uses an id, with a lock of PostgreSQL that ends with its connection.

A copied data folder or a cloned machine has the id of its original. Two such servers on one database would each take
the other's files for its own.
"""

from __future__ import annotations

import time
from contextlib import suppress
from typing import Final

from sqlalchemy import Connection, select, text
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from app.storage.database import Database
from app.storage.models import Server
from tsr_engine.errors import StorageError

__all__ = ["IdLock"]

_PATIENCE: Final = 3.0
"""Seconds until the connection of a dead server ends."""
_KEEPALIVES: Final = ("tcp_keepalives_idle = 10", "tcp_keepalives_interval = 5", "tcp_keepalives_count = 3")
"""Options with which the database notices within half a minute that a machine is gone."""


class IdLock:
    """The lock on the id of this server; without effect if the database is not shared.

    Args:
        database: has the id.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self._held: Connection | None = None

    def take(self) -> None:
        """Take the lock.

        Raises:
            StorageError: another server has the id, or the database cannot be reached.
        """
        if self._database.here is None:
            return
        end = time.monotonic() + _PATIENCE
        while not self._try():
            if time.monotonic() > end:
                raise StorageError(
                    f"Another server with the id of this data folder uses the database{self._other()}: one folder "
                    "is a copy of the other. Delete server.id in the copy, then start it; or stop that server."
                )
            time.sleep(0.1)

    def keep(self) -> bool:
        """Take the lock again if the database has restarted; False: another server has taken it.

        Raises:
            SQLAlchemyError: the database is unavailable.
        """
        if self._held is not None:
            try:
                self._held.execute(text("SELECT 1"))
            except SQLAlchemyError:
                self.free()
            else:
                return True
        return self._try()

    def free(self) -> None:
        """Release the lock."""
        held, self._held = self._held, None
        if held is not None:
            with suppress(SQLAlchemyError):
                held.invalidate()  # the lock belongs to the connection, so close it instead of returning it to the pool
                held.close()

    def _try(self) -> bool:
        here = self._database.here
        assert here is not None
        connection = self._database.engine.connect().execution_options(isolation_level="AUTOCOMMIT")
        try:
            for setting in _KEEPALIVES:
                connection.execute(text(f"SET {setting}"))
            taken = bool(connection.scalar(text("SELECT pg_try_advisory_lock(:id)"), {"id": int(here[:15], 16)}))
        except BaseException:
            connection.invalidate()
            connection.close()
            raise
        self._held = connection
        if not taken:
            self.free()
        return taken

    def _other(self) -> str:
        """Name of the server that has the id, if the database knows it."""
        with Session(self._database.engine) as session:
            name = session.scalar(select(Server.name).where(Server.id == self._database.here))
        return "" if name is None else f" ({name})"
