"""Runs are numbered in order, because a machine's clock may be wrong or set back."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa
from alembic import command
from alembic.config import Config

from app.cli.data_folder import describe_run_choice, find_run
from app.edits.earlier_run import earlier_corrections
from app.evidence.disagreement import other_run
from app.storage import migrate, models
from app.storage.database import Database
from app.storage.models import Edit, Run, TrackDocument, Video
from tests.app.toy_server import Server

VIDEO = "f" * 64
FIRST, SECOND, THIRD = "c" * 32, "a" * 32, "b" * 32
NOW = datetime(2026, 5, 1, 12, tzinfo=UTC)


def add(database: Database, run_id: str, created: datetime, **fields: Any) -> None:
    with database.write() as session:
        session.add(Run(id=run_id, video_id=VIDEO, name=run_id[0], state="complete", created=created, **fields))


@pytest.fixture
def wrong_clock(database: Database) -> Database:
    """Three runs; the clock was a day ahead for the first one, and an hour for the second."""
    with database.write() as session:
        session.add(Video(id=VIDEO, name="v.mp4", path="/v", size=1, state="ready", warnings=[]))
    for run_id, ahead in ((FIRST, 24), (SECOND, 1), (THIRD, 0)):
        add(database, run_id, NOW + timedelta(hours=ahead))
    with database.write() as session:
        document = {"key": "h000001", "revision": 1, "review": "accepted"}
        for run_id in (FIRST, SECOND):
            session.add(TrackDocument(run_id=run_id, key="h000001", revision=1, document=document))
            session.add(Edit(op_id=run_id, run_id=run_id, author="a", kind="x", command={}, before={}, after={}))
    return database


def test_runs_are_numbered_on_creation(wrong_clock: Database) -> None:
    with wrong_clock.read() as session:
        assert session.scalars(sa.select(Run.id).order_by(Run.order)).all() == [FIRST, SECOND, THIRD]


def test_the_newest_run_is_the_last_created_everywhere(wrong_clock: Database) -> None:
    with wrong_clock.read() as session:
        assert find_run(session, "v.mp4") == THIRD
        assert f"({SECOND}): give its id" in describe_run_choice(session, THIRD)
        other = other_run(session, FIRST, VIDEO)
        assert other is not None
        assert other.id == THIRD
        evidence: Any = None  # drawn tracks need none
        earlier = earlier_corrections(session, evidence, THIRD)
        assert earlier is not None
        assert earlier.run_id == SECOND
        assert earlier_corrections(session, evidence, FIRST) is None


def test_the_page_gets_runs_in_order(server: Server) -> None:
    database = server.context.database
    with database.write() as session:
        session.add(Video(id=VIDEO, name="v", path="/v", size=1, state="ready", warnings=[]))
    for run_id, ahead in ((FIRST, 24), (SECOND, 1), (THIRD, 0)):
        add(database, run_id, NOW + timedelta(hours=ahead))
    listed = server.client.get(f"/api/videos/{VIDEO}/runs").json()["runs"]
    assert [run["id"] for run in listed] == [THIRD, SECOND, FIRST]
    assert server.client.get(f"/api/videos/{VIDEO}").json()["latest_run"] == THIRD


def test_the_migration_numbers_existing_runs_and_keeps_their_edits(bare_database_url: str, tmp_path: Path) -> None:
    old = Database(bare_database_url)
    config = Config()
    config.set_main_option("script_location", str(migrate.MIGRATIONS))
    with old.engine.execution_options(tsr_write=True).connect() as connection:
        config.attributes["connection"] = connection
        command.upgrade(config, "0002")
        tables = sa.MetaData()
        tables.reflect(connection)

        def put(table: str, **values: Any) -> None:
            filled = dict.fromkeys((c.name for c in tables.tables[table].columns if not c.nullable), 0)
            mapped = models.Base.metadata.tables[table].columns
            for column in tables.tables[table].columns:
                if column.name in filled and mapped[column.name].type.python_type in (str, dict, bool, list):
                    filled[column.name] = mapped[column.name].type.python_type()
            filled = {name: value for name, value in filled.items() if name != "seq"}
            connection.execute(tables.tables[table].insert().values({**filled, **values}))

        put("videos", id=VIDEO, created=NOW)
        # not in the order of creation, and one what-if after its run
        for run_id, hours, parent in ((THIRD, 2, None), (FIRST, 0, None), (SECOND, 1, FIRST)):
            put("runs", id=run_id, video_id=VIDEO, parent_id=parent, created=NOW + timedelta(hours=hours))
        put("edits", op_id="one", run_id=THIRD, created=NOW)
        connection.commit()
    old.migrate(tmp_path / "backups")
    with old.read() as session:
        assert session.scalars(sa.select(Run.id).order_by(Run.order)).all() == [FIRST, SECOND, THIRD]
        assert session.scalars(sa.select(Run.order).order_by(Run.order)).all() == [1, 2, 3]
        assert session.scalars(sa.select(Edit.op_id)).all() == ["one"]
    add(old, "d" * 32, NOW - timedelta(days=1))
    with old.read() as session:
        assert session.get_one(Run, "d" * 32).order == 4
    assert len(list(tmp_path.glob("backups/*"))) == old.is_sqlite
    with old.engine.execution_options(tsr_write=True).connect() as connection:
        config.attributes["connection"] = connection
        command.downgrade(config, "0002")
        connection.commit()
        assert connection.exec_driver_sql("SELECT count(*) FROM edits").scalar() == 1
    old.close()
