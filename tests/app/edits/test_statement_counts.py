"""The number of SQL statements of an edit does not grow with the log."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager

import pytest
from sqlalchemy import event, text

from app.edits.commands import RelabelTrack
from app.errors import Conflict
from app.storage.database import Database
from tests.app.databases import new_database
from tests.app.edits.edit_services import EditServices, make_edit_services

MAX_STATEMENTS = 11
"""Statements of one edit, including locks and transaction beginnings."""


@contextmanager
def statements(edits: EditServices) -> Iterator[list[str]]:
    """The statements that a block sends."""
    sent: list[str] = []

    def hear(_connection: object, _cursor: object, statement: str, *_: object) -> None:
        sent.append(statement)

    event.listen(edits.database.engine, "before_cursor_execute", hear)
    yield sent
    event.remove(edits.database.engine, "before_cursor_execute", hear)


def relabel(edits: EditServices, number: int, key: str, revision: int, author: str = "ann") -> None:
    command = RelabelTrack(name="relabel_track", key=key, frame=3, class_id=number % 40)
    edits.service.apply(edits.run, f"op-{author}-{key}-{number:05d}", author, command, {key: revision})


def test_the_number_of_queries_of_an_edit_is_constant(edits: EditServices) -> None:
    counts = []
    for number in range(40):
        with statements(edits) as sent:
            relabel(edits, number, "m1", number)
        counts.append(len(sent))
    assert max(counts[1:]) <= MAX_STATEMENTS  # the first edit of an author creates rows that later ones update


def test_the_author_of_a_track_is_found_behind_many_other_edits(edits: EditServices) -> None:
    relabel(edits, 0, "m1", 0)
    relabel(edits, 1, "m1", 1, author="bea")
    relabel(edits, 2, "m1", 2)
    for number in range(70):
        relabel(edits, number, "m2", number, author="carl")
    for seen, who in ((0, "bea"), (1, "bea"), (2, "ann")):
        with pytest.raises(Conflict) as refused:
            relabel(edits, 90 + seen, "m1", seen)
        assert refused.value.details is not None
        assert refused.value.details["by"]["m1"]["author"] == who


def test_a_lost_connection_is_replaced(cluster: str, monkeypatch: pytest.MonkeyPatch) -> None:
    url = new_database(cluster)
    edits = make_edit_services(url)
    monkeypatch.setattr("app.storage.database.PING_INTERVAL_S", 0.0)
    relabel(edits, 0, "m1", 0)
    others = "datname = current_database() AND pid <> pg_backend_pid()"
    with closing(Database(url)) as another, another.read() as session:
        ended = session.execute(text(f"SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE {others}")).all()
    assert ended
    for number in range(1, 4):
        relabel(edits, number, "m1", number)
    edits.database.close()
