"""Times have a zone, on both databases and in every answer."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone

import pytest

from app.storage.database import Database
from app.storage.models import Video
from sample_videos import SHIPPED
from tests.app.toy_server import Server

NOON = datetime(2026, 3, 1, 12, 30, 15, 250000, UTC)


@pytest.mark.parametrize("given", [NOON, NOON.astimezone(timezone(timedelta(hours=5))), NOON.replace(tzinfo=None)])
def test_stored_times_are_read_in_utc(database: Database, given: datetime) -> None:
    with database.write() as session:
        session.add(Video(id="f" * 64, name="v", path="/v", size=1, warnings=[], created=given))
    with database.read() as session:
        found = session.get_one(Video, "f" * 64).created
        assert found.isoformat() == NOON.isoformat() == "2026-03-01T12:30:15.250000+00:00"
        assert session.query(Video).filter(Video.created <= given).count() == 1


def test_the_time_of_a_video_is_the_same_in_every_answer(server: Server) -> None:
    added = server.client.post("/api/videos", json={"path": str(SHIPPED[0].video)}).json()
    again = server.client.get(f"/api/videos/{added['id']}").json()
    assert added["created"] == again["created"]
    assert again["created"].endswith("+00:00")
