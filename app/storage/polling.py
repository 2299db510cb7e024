"""Queries that are called all the time and run only after the database has changed."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Callable
from contextlib import closing, suppress
from typing import Generic, TypeVar, cast

from sqlalchemy import Engine
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session
from sqlalchemy.pool import PoolProxiedConnection

T = TypeVar("T")


class Polled(Generic[T]):
    """The newest result of a query, for one thread at a time.

    SQLite counts the commits of other connections (``PRAGMA data_version``). Reading the count takes 4 microseconds,
    a query about half a millisecond, so a server without work leaves the processor idle. PostgreSQL has no such count,
    so every call queries there.
    """

    def __init__(self, engine: Engine, query: Callable[[Session], T]) -> None:
        """Prepare the query.

        Args:
            engine: of the database.
            query: returns the result; depends on nothing but the database.
        """
        self._engine = engine
        self._query = query
        self._counter: PoolProxiedConnection | None = None
        self._counter_lock = threading.Lock()  # SQLite crashes if a connection is closed while another thread uses it
        self._is_closed = False
        self._version: int | None = None
        self._result: T | None = None

    def __call__(self) -> T:
        """Return the current result.

        Raises:
            SQLAlchemyError: the database cannot be read.
        """
        version = self._count()  # before the query: a commit in between is seen by the next call
        if version is None or version != self._version:
            self._version = None
            with Session(self._engine, expire_on_commit=False) as session:
                self._result = self._query(session)
            self._version = version
        return cast("T", self._result)

    def close(self) -> None:
        """Close the connection, when no other thread uses it; later calls query every time."""
        with self._counter_lock:
            self._is_closed = True
            self._drop_counter()

    def _drop_counter(self) -> None:
        counter, self._counter = self._counter, None
        if counter is not None:
            counter.close()

    def _count(self) -> int | None:
        """Number that changes with each commit of another connection; None: unknown."""
        if self._engine.dialect.name != "sqlite":
            return None
        with self._counter_lock:
            if self._is_closed:
                return None
            with suppress(sqlite3.Error, SQLAlchemyError):  # the query that follows reports it
                if self._counter is None:
                    self._counter = self._engine.raw_connection()
                    self._counter.detach()  # the pool's connections are used for commits of this process, which count
                with closing(self._counter.cursor()) as cursor:
                    cursor.execute("PRAGMA data_version")
                    return int(cursor.fetchall()[0][0])
            self._drop_counter()
            return None
