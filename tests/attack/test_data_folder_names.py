"""Data folders with names that have a meaning in URLs: each has its own database inside."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

from app.settings import Settings
from app.storage.database import Database, sqlite_file
from tests.app.toy_server import SECRET, Server

NAMES = ["a?b", "a?", "a?uri=true", "a%20b", "a%2fb", "100%", "a#b", "ü", "a b", "a&b=c", ":memory:", "file:a", "@host"]


def one_row(home: Path) -> int:
    with sqlite3.connect(home / "tsr.sqlite") as connection:
        found = connection.execute("SELECT count(*) FROM alembic_version").fetchone()[0]
    connection.close()
    return int(found)


def test_each_home_contains_its_own_database(tmp_path: Path) -> None:
    for name in NAMES:
        home = tmp_path / name
        server = Server(home)
        with server.client:
            assert server.client.get("/api/videos").json() == {"videos": []}, name
        assert one_row(home) == 1
        assert sqlite_file(server.settings.database) == (home / "tsr.sqlite").resolve()
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(NAMES)


def test_a_file_url_names_the_file_to_lock(tmp_path: Path) -> None:
    file = tmp_path / "a b.sqlite"
    assert sqlite_file(f"sqlite:///file:{tmp_path}/a%2520b.sqlite?uri=true") == file
    database = Database(f"sqlite:///file:{tmp_path}/a%2520b.sqlite?uri=true")
    database.migrate()
    database.close()
    assert file.is_file()


@pytest.mark.parametrize("used", [True, False])
def test_a_database_misplaced_by_an_earlier_version_is_moved(tmp_path: Path, used: bool) -> None:
    beside = Database(f"sqlite:///{tmp_path / 'a'}")
    beside.migrate()
    with beside.write() as session:
        session.connection().exec_driver_sql(
            "INSERT INTO events (kind, subject, data, time) VALUES ('k', 's', '{}', '2026-01-01')"
        )
    beside.close()
    home = tmp_path / "a?b"
    home.mkdir()
    if used:
        (home / "token").write_text(SECRET)
    server = Server(home)
    with server.client, server.context.database.read() as session:
        assert session.connection().exec_driver_sql("SELECT count(*) FROM events").scalar() == int(used)
    assert (tmp_path / "a").is_file()


def test_a_given_database_url_is_used(tmp_path: Path) -> None:
    assert Settings(home=tmp_path, database_url="postgresql+psycopg://a@/b").database == "postgresql+psycopg://a@/b"
