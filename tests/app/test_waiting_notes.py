"""Runs that versions without notes have left waiting for another server get their note from the migration."""

from __future__ import annotations

import pytest
from alembic import command
from alembic.config import Config

from app.storage import migrate
from app.storage.database import Database
from app.storage.models import Run, Server, Video

VIDEO, FIRST, SECOND, SHARED = "f" * 64, "1" * 32, "2" * 32, "3" * 32


@pytest.mark.parametrize(
    ("servers", "state", "place", "note"),
    [
        ({FIRST: 5, SECOND: 7, SHARED: 0}, "queued", SECOND, "the server name 2 has the video"),
        ({FIRST: 5, SECOND: 7, SHARED: 0}, "failed", SECOND, ""),
        ({FIRST: 5, SHARED: 0}, "queued", FIRST, ""),
        ({FIRST: 5, SECOND: 7, SHARED: 0}, "queued", SHARED, ""),
        ({}, "queued", None, ""),
    ],
)
def test_the_migration_names_the_other_server(
    bare_database_url: str, servers: dict[str, int], state: str, place: str | None, note: str
) -> None:
    database = Database(bare_database_url)
    database.migrate()
    with database.write() as session:
        session.add(Video(id=VIDEO, name="v.mp4", path="/v", size=1, state="ready", warnings=[]))
        session.flush()
        session.add_all(Server(id=key, name=f"name {key[0]}", beats=beats) for key, beats in servers.items())
        session.add(Run(id="a" * 32, video_id=VIDEO, name="Run 1", state=state, place=place))
    config = Config()
    config.set_main_option("script_location", str(migrate.MIGRATIONS))
    with database.engine.execution_options(tsr_write=True).connect() as connection:
        config.attributes["connection"] = connection
        command.downgrade(config, "0013")
        connection.commit()
    database.migrate()
    with database.read() as session:
        assert session.get_one(Run, "a" * 32).note == note
    database.close()
