"""One database: SQLite in the data folder, or PostgreSQL by address; the same code for both."""

from __future__ import annotations

import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final, TypeVar
from urllib.parse import unquote

from sqlalchemy import URL, Connection, create_engine, event, make_url, text
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.exc import ArgumentError, DBAPIError, InvalidatePoolError, NoSuchModuleError, OperationalError
from sqlalchemy.orm import Session
from sqlalchemy.pool import ConnectionPoolEntry

from app.errors import ApiError, Busy, Invalid, StorageFull
from app.storage.polling import Polled
from tsr_engine.errors import UsageError
from tsr_engine.io.storage_problems import database_problem

T = TypeVar("T")

WAIT_MS = 8000
"""Milliseconds that SQLite waits for another writer."""
_ANALYZE_ROWS = 100_000
"""Rows of each index that ``ANALYZE`` reads: takes a fraction of a second for a database of any size.

SQLite assumes that no value is more frequent than this. With 1,000 it assumed that a large library has fewer current
tracks than tracks with a note or of a few videos, and each search scanned all of them.
"""

PING_INTERVAL_S = 1.0
"""Seconds after a test in which a connection to PostgreSQL is not tested again."""
NETWORK_OPTIONS: Final = {
    "connect_timeout": 5,
    "tcp_user_timeout": 15_000,
    "keepalives_idle": 10,
    "keepalives_interval": 5,
    "keepalives_count": 3,
}
"""Options of libpq, s and ms: a network that drops packets ends a query after 25 s, not after the kernel's 15 minutes.

The address of the database may name others.
"""
_PINGED_AT: Final = "tsr_pinged_at"
_DISK_FULL: Final = "The disk is full: nothing was saved. Free some space; unsaved corrections are kept in the page."
_FULL: Final = "53100"
_READ_ONLY: Final = "25006"
_TEMPORARY: Final = ("08", "57P", "53300", "53200", "55P03", "40001", "40P01")
"""SQLSTATEs of temporary failures: no connection, server ends or starts, too many connections, no memory, locks."""


def _address(url: str | URL) -> URL:
    """Parse an address and check that its driver is installed.

    Raises:
        UsageError: it is no address, or its driver is not installed.
    """
    try:
        address = make_url(url)
        address.get_dialect()
    except (ArgumentError, NoSuchModuleError):
        raise UsageError(
            "Expected the address of a database, such as postgresql+psycopg://user@host/name. Got one that starts with "
            f"{str(url).partition(':')[0]!r}."
        ) from None
    return address


def sqlite_file(url: str | URL) -> Path | None:
    """Return the file of a SQLite database, links resolved; None: another database, or one in memory.

    Raises:
        UsageError: it is no address, or its driver is not installed.
    """
    address = _address(url)
    name = address.database or ""
    if address.query.get("uri") and name.startswith("file:"):
        name = unquote(name.removeprefix("file:"))
    return Path(name).resolve() if address.get_backend_name() == "sqlite" and name and name != ":memory:" else None


class Database:
    """Sessions on one database.

    Reading sessions see one state and never block others. Writing sessions take SQLite's write lock at once, so they
    wait for each other instead of failing half way. SQLite's lock is not fair: one of many threads could wait for
    seconds and then fail. So the threads of one process first queue up here.
    """

    def __init__(self, url: str | URL, server: str | None = None, shared: str | None = None) -> None:
        """Configure the connections.

        Args:
            url: address.
            server: this server, to which new rows belong (``app.storage.servers``); SQLite has only one server.
            shared: id of the files that this server shares with others; None: none.
        """
        address = _address(url)
        self.is_sqlite = address.get_backend_name() == "sqlite"
        self.server = None if self.is_sqlite else server
        self.shared = None if self.is_sqlite else shared
        if self.is_sqlite:
            self.engine = create_engine(
                address, pool_size=16, max_overflow=48, connect_args={"check_same_thread": False}
            )
            event.listen(self.engine, "connect", _on_connect)
            event.listen(self.engine, "begin", _on_begin)
        else:
            # one per thread of the server: a connection beyond the pool costs more than an edit
            options = {"tsr_server": server, "tsr_shared": shared}
            network = {name: value for name, value in NETWORK_OPTIONS.items() if name not in address.query}
            self.engine = create_engine(
                address, pool_size=40, max_overflow=8, execution_options=options, connect_args=network
            )
            event.listen(self.engine, "checkout", self._on_checkout)
        self._closed = False
        event.listen(self.engine, "checkin", self._on_checkin)
        self._writer = self.engine.execution_options(tsr_write="FULL")
        self._fast_writer = self.engine.execution_options(tsr_write="NORMAL")
        self._query_engine = (
            self.engine if self.is_sqlite else self.engine.execution_options(isolation_level="AUTOCOMMIT")
        )
        self._write_lock = threading.RLock()
        self._on_close: list[Callable[[], None]] = []

    @contextmanager
    def read(self) -> Iterator[Session]:
        """Yield a session that only reads."""
        with Session(self.engine, expire_on_commit=False) as session:
            yield session

    @contextmanager
    def read_once(self) -> Iterator[Session]:
        """Yield a session for a single query; on PostgreSQL without a transaction, which saves two round trips."""
        with Session(self._query_engine, expire_on_commit=False) as session:
            yield session

    def polled(self, query: Callable[[Session], T]) -> Callable[[], T]:
        """Return a function for a query that is called all the time; it runs only after a commit (:class:`Polled`).

        One thread at a time may call it.
        """
        polled = Polled(self.engine, query)
        self._on_close.append(polled.close)
        return polled

    @contextmanager
    def write(self, *, durable: bool = True) -> Iterator[Session]:
        """Yield a session whose changes are committed together at the end, or not at all.

        Args:
            durable: whether the changes must survive a loss of power, for which SQLite waits for the disk. If not, a
                loss of power may undo the last transactions, but never parts of them; the end of a process undoes none.
                PostgreSQL always waits, because several machines write.
        """
        writer = self._writer if durable else self._fast_writer
        with self._hold_write_lock(), Session(writer, expire_on_commit=False) as session, session.begin():
            yield session

    @contextmanager
    def _hold_write_lock(self) -> Iterator[None]:
        """Wait for this process's turn to write to SQLite; give up after as long as SQLite would wait."""
        is_held = self.is_sqlite and self._write_lock.acquire(timeout=WAIT_MS / 1000)
        try:
            yield
        finally:
            if is_held:
                self._write_lock.release()

    def migrate(self, backup: Path | None = None) -> None:
        """Migrate the tables to this version.

        Args:
            backup: folder to which a SQLite file is copied before an existing database changes.

        Raises:
            StorageError: the database is newer than this version, or cannot be changed.
        """
        from app.storage.migrate import migrate_tables  # alembic is slow to load and only needed here

        migrate_tables(self._writer, backup if self.is_sqlite else None)

    def analyze(self) -> None:
        """Let SQLite sample each table (``ANALYZE``), so that it chooses good indexes.

        PostgreSQL does that by itself. Connections read the result when they are opened, so idle ones are closed.
        """
        if self.is_sqlite:
            with self.write() as session:
                session.execute(text(f"PRAGMA analysis_limit = {_ANALYZE_ROWS}"))
                session.execute(text("ANALYZE"))
            self.engine.dispose()

    def close(self) -> None:
        """Close all connections; one in use is closed when its thread returns it."""
        self._closed = True
        for close in self._on_close:
            close()
        self.engine.dispose()

    def _on_checkout(self, connection: DBAPIConnection, record: ConnectionPoolEntry, _proxy: object) -> None:
        """Test a connection before its use, unless that was done a moment ago; a lost one is replaced."""
        now = time.monotonic()
        if now - record.info.get(_PINGED_AT, -PING_INTERVAL_S) < PING_INTERVAL_S:
            return
        dialect = self.engine.dialect
        try:
            dialect.do_ping(connection)
        except dialect.loaded_dbapi.Error as error:
            if dialect.is_disconnect(error, connection, None):  # type: ignore[arg-type]
                raise InvalidatePoolError from error
            raise
        record.info[_PINGED_AT] = now

    def _on_checkin(self, _connection: object, record: ConnectionPoolEntry) -> None:
        # after close the pool is unused: the connection would stay open in it
        if self._closed:
            record.invalidate()


def _on_connect(connection: sqlite3.Connection, _record: object) -> None:
    connection.isolation_level = None  # we begin transactions explicitly
    cursor = connection.cursor()
    for pragma in ("journal_mode = WAL", "synchronous = FULL", "foreign_keys = ON", f"busy_timeout = {WAIT_MS}"):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def _on_begin(connection: Connection) -> None:
    synchronous = connection.get_execution_options().get("tsr_write")
    if synchronous is not None and connection.info.get("synchronous", "FULL") != synchronous:
        connection.exec_driver_sql(f"PRAGMA synchronous = {synchronous}")
        connection.info["synchronous"] = synchronous
    connection.exec_driver_sql("BEGIN" if synchronous is None else "BEGIN IMMEDIATE")


def storage_failure(error: DBAPIError) -> ApiError | None:
    """Convert a failure of the database to a refusal for people; None: it is another failure.

    PostgreSQL's messages depend on the language of its machine, so use its SQLSTATE, and whether the connection is
    lost.
    """
    text = str(error.orig).lower()
    if isinstance(error.orig, sqlite3.Error):
        return _sqlite_failure(error.orig, text)
    state = str(getattr(error.orig, "sqlstate", None) or "")
    if state.startswith(_FULL):
        return StorageFull(_DISK_FULL)
    if state.startswith(_READ_ONLY):
        return StorageFull(
            "The database is read-only at the moment. Unsaved corrections are kept in the page.",
            code="storage_readonly",
        )
    # an error without a statement comes from is_connecting and has no SQLSTATE
    is_connecting = isinstance(error, OperationalError) and not state and error.statement is None
    if error.connection_invalidated or is_connecting or state.startswith(_TEMPORARY):
        return Busy("The database is unavailable for a moment. Repeat the request later.", code="database_busy")
    if "nul (0x00)" in text:
        return Invalid("A text contains the character NUL, which cannot be stored.")
    return None


def _sqlite_failure(error: sqlite3.Error, text: str) -> ApiError | None:
    if "disk is full" in text:
        return StorageFull(_DISK_FULL)
    if "disk i/o error" in text and database_problem(error) == "limit":
        return StorageFull(
            "The database may not grow: the server's limit on the size of files (ulimit -f) is reached. Nothing was "
            "saved. Raise the limit; unsaved corrections are kept in the page.",
            code="storage_limit",
        )
    if "disk i/o error" in text:
        return StorageFull(
            "The disk of the data folder fails: nothing was saved. Check the disk; unsaved corrections are kept in the "
            "page.",
            code="storage_failed",
        )
    if "locked" in text or "busy" in text:
        return Busy("The database is busy. Repeat the request later.", code="database_busy")
    if "readonly" in text:
        return StorageFull("The data folder cannot be written. Check its permissions.", code="storage_readonly")
    return None
