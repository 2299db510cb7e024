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

_TIMEOUT_S: Final = 3.0
"""Seconds until the connection of a dead server ends."""
_KEEPALIVES: Final = ("tcp_keepalives_idle = 10", "tcp_keepalives_interval = 5", "tcp_keepalives_count = 3")
"""Options with which the database notices within half a minute that a machine is lost."""


class IdLock:
    """The lock on the id of this server; without effect if the database is not shared."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._connection: Connection | None = None

    def acquire(self) -> None:
        """Take the lock.

        Raises:
            StorageError: another server has the id, or the database cannot be reached.
        """
        if self._database.server is None:
            return
        deadline = time.monotonic() + _TIMEOUT_S
        while not self._try():
            if time.monotonic() > deadline:
                raise StorageError(
                    f"Another server with the id of this data folder uses the database{self._other_server()}: one "
                    "folder is a copy of the other. Delete server.id in the copy, then start it; or stop that server."
                )
            time.sleep(0.1)

    def ensure(self) -> bool:
        """Take the lock again if the database has restarted; False: another server has taken it.

        Raises:
            SQLAlchemyError: the database is unavailable.
        """
        if self._connection is not None:
            try:
                self._connection.execute(text("SELECT 1"))
            except SQLAlchemyError:
                self.release()
            else:
                return True
        return self._try()

    def release(self) -> None:
        """Release the lock."""
        connection, self._connection = self._connection, None
        if connection is not None:
            with suppress(SQLAlchemyError):
                connection.invalidate()  # the lock belongs to the connection, so do not return it to the pool
                connection.close()

    def _try(self) -> bool:
        server = self._database.server
        assert server is not None
        connection = self._database.engine.connect().execution_options(isolation_level="AUTOCOMMIT")
        try:
            for setting in _KEEPALIVES:
                connection.execute(text(f"SET {setting}"))
            lock = text("SELECT pg_try_advisory_lock(:id)")
            is_acquired = bool(connection.scalar(lock, {"id": int(server[:15], 16)}))
        except BaseException:
            connection.invalidate()
            connection.close()
            raise
        self._connection = connection
        if not is_acquired:
            self.release()
        return is_acquired

    def _other_server(self) -> str:
        """Name of the server that has the id, if the database knows it."""
        with Session(self._database.engine) as session:
            name = session.scalar(select(Server.name).where(Server.id == self._database.server))
        return "" if name is None else f" ({name})"
