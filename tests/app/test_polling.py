"""Queries that run only after a commit."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from sqlalchemy.engine.interfaces import DBAPICursor
from sqlalchemy.exc import OperationalError
from sqlalchemy.orm import Session
from sqlalchemy.pool import PoolProxiedConnection

from app.events import EventBus
from app.storage.database import Database
from tests.waiting import time_limit

BUS = EventBus()


class EventCounter:
    """The number of the newest event, and how often it was asked for."""

    def __init__(self, database: Database) -> None:
        self.times = 0
        self.error: Exception | None = None
        self.newest = database.polled(self._ask)

    def _ask(self, session: Session) -> int:
        self.times += 1
        if self.error is not None:
            raise self.error
        return BUS.newest(session)


def publish(database: Database) -> None:
    with database.write() as session:
        BUS.publish(session, "test", "subject", {})


def test_the_answer_is_always_the_newest(database: Database) -> None:
    asked = EventCounter(database)
    for number in range(4):
        assert [asked.newest() for _ in range(3)] == [number] * 3
        publish(database)


def test_commits_of_other_processes_count(database: Database, database_url: str) -> None:
    asked = EventCounter(database)
    with closing(Database(database_url)) as other:
        before = asked.newest()
        publish(other)
        assert asked.newest() == before + 1


@pytest.fixture
def sqlite(tmp_path: Path) -> Iterator[Database]:
    """A database whose changes are counted."""
    with closing(Database(f"sqlite:///{tmp_path / 'tsr.sqlite'}")) as made:
        made.migrate()
        yield made


def test_sqlite_queries_once_for_each_commit(sqlite: Database) -> None:
    asked = EventCounter(sqlite)
    for commits in range(1, 4):
        for _ in range(5):
            asked.newest()
            with sqlite.read() as session:
                session.connection().exec_driver_sql("SELECT count(*) FROM events")
        assert asked.times == commits
        publish(sqlite)
    before = asked.newest()
    with sqlite.write() as session:
        BUS.publish(session, "test", "subject", {})
        session.rollback()
    assert (asked.newest(), asked.times) == (before, 4), "a transaction that is rolled back changes nothing"


def test_a_failed_query_is_repeated(sqlite: Database) -> None:
    asked = EventCounter(sqlite)
    asked.newest()
    publish(sqlite)
    asked.error = OperationalError("SELECT", {}, Exception("the disk fails"))
    for _ in range(2):
        with pytest.raises(OperationalError):
            asked.newest()
    asked.error = None
    assert (asked.newest(), asked.times) == (1, 4)


def test_tidying_does_not_hide_later_commits(sqlite: Database) -> None:
    asked = EventCounter(sqlite)
    asked.newest()
    sqlite.analyze()  # closes the idle connections
    publish(sqlite)
    assert asked.newest() == 1


def test_a_closed_database_leaves_no_open_file(sqlite: Database, tmp_path: Path) -> None:
    asked = EventCounter(sqlite)
    asked.newest()
    sqlite.close()
    links = (os.path.realpath(f"/proc/self/fd/{fd}") for fd in os.listdir("/proc/self/fd"))  # noqa: PTH208
    assert not [link for link in links if link.startswith(str(tmp_path.resolve()))]


def test_a_connection_in_use_is_closed_after_its_use(sqlite: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = EventCounter(sqlite)
    using, may_end, order = threading.Event(), threading.Event(), list[str]()
    open_connection = sqlite.engine.raw_connection

    def slow_connection() -> PoolProxiedConnection:
        connection = open_connection()
        if using.is_set():
            return connection
        cursor, close = connection.cursor, connection.close

        def slow_cursor() -> DBAPICursor:
            using.set()
            assert may_end.wait(time_limit(10))
            order.append("used")
            return cursor()

        def noted_close() -> None:
            order.append("closed")
            close()

        monkeypatch.setattr(connection, "cursor", slow_cursor)
        monkeypatch.setattr(connection, "close", noted_close)
        return connection

    monkeypatch.setattr(sqlite.engine, "raw_connection", slow_connection)
    reader = threading.Thread(target=asked.newest)
    closer = threading.Thread(target=sqlite.close)
    reader.start()
    assert using.wait(time_limit(10))
    closer.start()
    closer.join(0.1)
    may_end.set()
    for thread in (reader, closer):
        thread.join(time_limit(10))
    assert order == ["used", "closed"]
    assert asked.newest() == 0
    assert order == ["used", "closed"], "no connection is opened after the end"
