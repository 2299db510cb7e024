"""The database: migrations, waiting writers, a full disk, a newer version's file."""

from __future__ import annotations

import sqlite3
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from sqlalchemy import MetaData, select, text
from sqlalchemy.exc import OperationalError

from app.events import EventBus
from app.storage import database as database_module
from app.storage import migrate
from app.storage.database import Database, storage_failure
from app.storage.models import Assignment, Base, Event, Video
from tests.app.databases import new_database
from tests.app.toy_server import SECRET, Server
from tests.waiting import time_limit
from tsr_engine.errors import StorageError, UsageError

NOW = datetime(2026, 5, 1, 12, tzinfo=UTC)


@pytest.fixture
def database(tmp_path: Path) -> Database:
    database = Database(f"sqlite:///{tmp_path / 'tsr.sqlite'}")
    database.migrate()
    return database


def test_migrations_create_the_tables_of_the_models(database: Database) -> None:
    with database.engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), Base.metadata) == []
        assert connection.exec_driver_sql("PRAGMA journal_mode").scalar() == "wal"
        assert connection.exec_driver_sql("PRAGMA synchronous").scalar() == 2  # FULL
        assert connection.exec_driver_sql("PRAGMA foreign_keys").scalar() == 1
    database.close()


def test_sqlite_syncs_unless_a_change_may_be_lost(database: Database) -> None:
    for durable, level in ((True, 2), (False, 1), (True, 2)):
        with database.write(durable=durable) as session:
            assert session.scalar(text("PRAGMA synchronous")) == level
    database.close()


def test_migrations_make_the_same_on_postgresql(cluster: str) -> None:
    database = Database(new_database(cluster, bare=True))
    database.migrate()
    database.migrate()
    with database.engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), Base.metadata) == []
    database.close()


def test_ids_of_removed_assignments_are_not_given_again_after_the_migration(bare_database_url: str) -> None:
    database = Database(bare_database_url)
    config = Config()
    config.set_main_option("script_location", str(migrate.MIGRATIONS))
    with database.engine.execution_options(tsr_write="FULL").connect() as connection:
        config.attributes["connection"] = connection
        command.upgrade(config, "0014")
        tables = MetaData()
        tables.reflect(connection)
        video = {"id": "f" * 64, "name": "v.mp4", "path": "/v", "size": 1, "state": "ready", "warnings": []}
        video |= {"owned": False, "sample": False, "created": NOW}
        person = {"id": "a" * 32, "name": "Anna", "key": "anna", "role": "annotator", "created": NOW}
        fields = {"video_id": "f" * 64, "person_id": "a" * 32, "first": 0, "state": "done", "comment": "x"}
        fields |= {"changed_by": "Rolf", "revision": 3, "created": NOW, "changed": NOW}
        rows = ("videos", video), ("people", person), ("assignments", fields), ("assignments", fields)
        for table, values in rows:
            connection.execute(tables.tables[table].insert().values(values))
        connection.commit()
    database.migrate()
    with database.write() as session:
        kept, newest = session.scalars(select(Assignment).order_by(Assignment.id))
        assert (kept.id, newest.id, kept.video_id, kept.comment, kept.revision) == (1, 2, "f" * 64, "x", 3)
        session.delete(newest)
        session.flush()
        later = Assignment(video_id="f" * 64, person_id="a" * 32, changed_by="Rolf")
        session.add(later)
        session.flush()
        assert later.id == 3
        session.delete(session.get_one(Video, "f" * 64))
    with database.read() as session:
        assert session.scalars(select(Assignment)).all() == []
    database.close()


def test_migrating_twice_changes_nothing(database: Database, tmp_path: Path) -> None:
    database.migrate(tmp_path / "backups")
    assert not (tmp_path / "backups").exists()
    database.close()


def test_a_newer_database_is_refused(database_url: str) -> None:
    database = Database(database_url)
    with database.write() as session:
        session.connection().exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
    option = "--home" if database.is_sqlite else "--database"
    with pytest.raises(StorageError, match=rf"newer version .*, restore a backup of this version, .* {option}\.$"):
        database.migrate()
    database.close()


def test_an_older_database_is_copied_before_it_changes(tmp_path: Path) -> None:
    database = Database(f"sqlite:///{tmp_path / 'tsr.sqlite'}")
    database.migrate()
    migrate.back_up(database.engine, tmp_path / "backups")  # what a migration from an older revision does first
    copy = next((tmp_path / "backups").iterdir())
    with sqlite3.connect(copy) as connection:
        assert connection.execute("SELECT version_num FROM alembic_version").fetchone() is not None
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    connection.close()
    database.close()


@pytest.mark.parametrize("content", [b"garbage" * 1000, b"SQLite format 3\0" + b"x" * 4080])
def test_a_damaged_database_is_reported_with_its_copies(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "tsr.sqlite"
    file.write_bytes(content)
    database = Database(f"sqlite:///{file}")
    with pytest.raises(StorageError) as refused:
        database.migrate(tmp_path / "backups")
    assert str(refused.value) == (
        f"The database {file} is damaged or not one of tsr: file is not a database. Move it away and restore a copy "
        f"from {tmp_path / 'backups'}, or name another data folder with --home."
    )
    assert file.read_bytes() == content
    database.close()


def test_a_database_damaged_during_the_copy_is_reported(
    database: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(_engine: object, _folder: Path) -> None:
        raise sqlite3.DatabaseError("database disk image is malformed")

    with database.write() as session:
        session.connection().exec_driver_sql("UPDATE alembic_version SET version_num = '0002'")
    monkeypatch.setattr(migrate, "back_up", broken)
    with pytest.raises(StorageError, match=r"malformed\. Move it away and restore a copy from .*backups"):
        database.migrate(tmp_path / "backups")
    database.close()


def test_an_unreadable_database_is_reported(tmp_path: Path) -> None:
    for url, words in (
        (f"sqlite:///{tmp_path}", f"The database {tmp_path} cannot be used: unable to open database file."),
        ("postgresql+psycopg://somebody@/name?host=/nowhere", "The database cannot be used: "),
    ):
        database = Database(url)
        with pytest.raises(StorageError) as refused:
            database.migrate()
        assert str(refused.value).startswith(words)
        assert "\n" not in str(refused.value)
        database.close()


def test_writers_behind_a_hanging_writer_fail_after_a_timeout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(database_module, "WAIT_MS", 50)
    database = Database(f"sqlite:///{tmp_path / 'tsr.sqlite'}")
    database.migrate()

    def write() -> None:
        with database.write() as session:
            session.execute(text("SELECT 1"))

    with ThreadPoolExecutor(1) as pool:
        with database.write() as session:
            session.execute(text("SELECT 1"))
            with pytest.raises(OperationalError, match="locked"):
                pool.submit(write).result(60)
        pool.submit(write).result(60)
    database.close()


def test_writers_wait_for_each_other(database: Database) -> None:
    bus = EventBus()

    def work(number: int) -> None:
        for _ in range(25):
            with database.write() as session:
                seen = bus.newest(session)
                bus.publish(session, "test", str(number), {"seen": seen})

    with ThreadPoolExecutor(8) as threads:
        list(threads.map(work, range(8)))
    with database.read() as session:
        events = bus.after(session, 0)
        # each writer saw all earlier commits: none lost, none interleaved
        assert [event.data["seen"] for event in events] == [event.seq - 1 for event in events]
        assert len(events) == 200
    database.close()


def test_a_failed_transaction_leaves_nothing(database: Database) -> None:
    def fail() -> None:
        with database.write() as session:
            session.add(Event(kind="a", subject="b", data={}))
            session.flush()
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    with database.read() as session:
        assert EventBus().newest(session) == 0
    database.close()


def test_a_locked_database_is_reported_as_busy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.storage.database.WAIT_MS", 50)
    server = Server(tmp_path / "home")
    with server.client:
        blocker = sqlite3.connect(tmp_path / "home" / "tsr.sqlite", isolation_level=None, check_same_thread=False)
        blocker.execute("BEGIN IMMEDIATE")
        began = time.monotonic()
        answer = server.client.delete(f"/api/videos/{'0' * 64}")
        assert answer.status_code == 503, answer.text
        assert answer.json()["error"]["code"] == "database_busy"
        assert time.monotonic() - began < time_limit(5)
        assert server.client.get("/api/videos").status_code == 200  # reading continues
        blocker.execute("ROLLBACK")
        blocker.close()
        assert server.client.delete(f"/api/videos/{'0' * 64}").status_code == 404


def test_a_full_disk_is_reported_and_reading_continues(server: Server) -> None:
    context = server.context
    with context.database.engine.connect() as connection:
        pages = connection.exec_driver_sql("PRAGMA page_count").scalar()
    # SQLite's own file limit gives the same error without filling a disk
    from sqlalchemy import event

    for warmer in [thread for thread in threading.enumerate() if thread.name == "tsr-warm"]:
        warmer.join()  # it begins its own transaction, during which no listener can be added

    @event.listens_for(context.database.engine, "begin")
    def limit(connection: object) -> None:
        connection.exec_driver_sql(f"PRAGMA max_page_count = {pages}")  # type: ignore[attr-defined]

    context.database.engine.dispose()

    def fill() -> None:
        for _ in range(100):
            with context.database.write() as session:
                context.events.publish(session, "test", "x", {"text": "y" * 4000})

    with pytest.raises(OperationalError) as full:
        fill()
    failure = storage_failure(full.value)
    assert failure is not None
    assert failure.status == 507
    assert server.client.get("/api/videos").json() == {"videos": []}
    event.remove(context.database.engine, "begin", limit)
    context.database.engine.dispose()
    with context.database.write() as session:
        context.events.publish(session, "test", "x", {})


def test_a_folder_has_one_secret(tmp_path: Path) -> None:
    from app.security.tokens import home_token

    first = home_token(tmp_path)
    assert home_token(tmp_path) == first
    assert (tmp_path / "token").stat().st_mode & 0o077 == 0
    (tmp_path / "token").write_text("short")
    with pytest.raises(StorageError, match="at least 16"):
        home_token(tmp_path)
    assert len(SECRET) >= 16


@pytest.mark.parametrize("url", ["foo://x", "nonsense", "postgresql+no_such://x"])
def test_an_unusable_database_url_is_refused_in_a_sentence(url: str) -> None:
    with pytest.raises(UsageError, match="Expected the address of a database"):
        Database(url)
    with pytest.raises(UsageError) as error:
        Database("foo://user:secret@host/name")
    assert "secret" not in str(error.value)


def test_a_connection_in_use_is_closed_after_the_database(tmp_path: Path) -> None:
    database = Database(f"sqlite:///{tmp_path / 'a.sqlite'}")
    database.migrate()
    with database.read() as session:
        used = session.connection().connection.driver_connection
        database.close()
        assert session.connection().exec_driver_sql("SELECT 1").scalar() == 1
    assert used is not None
    with pytest.raises(sqlite3.ProgrammingError, match="closed"):
        used.execute("SELECT 1")
