"""Thousands of videos are assigned at once, on both kinds of database."""

from __future__ import annotations

import pytest
from sqlalchemy import event

from app.errors import Conflict
from app.events import EventBus
from app.people.assignments import AssignmentService
from app.people.identity import Identity
from app.people.service import PeopleService
from app.storage.database import Database
from app.storage.models import Video


def test_many_videos_are_assigned_with_few_statements(database: Database, people: PeopleService) -> None:
    people.add("Anna", "annotator")
    videos = [f"{i:064x}" for i in range(1200)]
    with database.write() as session:
        session.add_all(Video(id=each, name="v", path="/v", size=1, state="ready", warnings=[]) for each in videos)
    statements: list[str] = []
    event.listen(database.engine, "before_cursor_execute", lambda *given: statements.append(given[2]))
    events = EventBus()
    service, rolf = AssignmentService(database, events), Identity("reviewer", name="Rolf")
    made = service.create(rolf, [*videos, videos[0]], "Anna", 0, None, "all")
    assert len(statements) < 30
    assert [one.video_id for one in made] == videos
    assert sorted(service.views(person="Anna"), key=lambda one: one.id) == made
    with database.read() as session:
        told = [each for each in events.after(session, 0, 10_000) if each.kind == "assignment"]
    assert [each.data for each in told] == [one.model_dump(mode="json") for one in made]
    with pytest.raises(Conflict, match="Anna has v already, whole"):
        service.create(rolf, videos[-1:], "Anna", 5, None, "")
