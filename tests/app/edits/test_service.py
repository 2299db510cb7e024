"""The log: revisions, and documents as they are stored."""

from __future__ import annotations

import pytest
from sqlalchemy import func, select

from app.edits.documents import TrackDoc
from app.errors import Conflict, Invalid, NotFound, PreconditionRequired
from app.storage.models import Edit, Event
from tests.app.edits.edit_services import EditServices
from tests.app.edits.sent_edits import relabel, send


def test_missing_stale_and_repeated_revisions(edits: EditServices) -> None:
    with pytest.raises(PreconditionRequired):
        send(edits, "1", relabel(3), None)
    first = send(edits, "1", relabel(3), {"m1": 0})
    assert first.docs[0].revision == 1
    again = send(edits, "1", relabel(3), {"m1": 0})
    assert again.docs == first.docs
    with pytest.raises(Conflict) as caught:
        send(edits, "2", relabel(9), {"m1": 0}, "bob")
    details = caught.value.details
    assert details is not None
    assert (details["current"][0]["class_id"], details["yours"][0]["class_id"]) == (3, 9)
    assert len(edits.service.log(edits.run, 0)) == 1
    with pytest.raises(NotFound):
        edits.service.annotation("0" * 32, "ann")
    with pytest.raises(Invalid):
        send(edits, "3", relabel(9, "m77"), {})
    with edits.database.read() as session:
        assert session.scalar(select(func.count()).select_from(Event).where(Event.kind == "edit")) == 1


def test_a_number_with_zeros_names_no_track(edits: EditServices) -> None:
    send(edits, "1", {"name": "add_note", "frame": 5, "key": "m1", "note_id": "n1", "text": "bent"}, {"m1": 0})
    with pytest.raises(Invalid):
        send(edits, "2", {"name": "set_review", "frame": 5, "key": "m001", "review": "accepted"}, {"m001": 0}, "bob")
    assert [note.text for note in edits.documents()["m1"].notes] == ["bent"]


def test_documents_round_trip(edits: EditServices) -> None:
    answer = send(edits, "1", {"name": "set_box", "frame": 4, "key": "m1", "box": [0.1, 0.2, 0.7, 1e4 / 3]}, {"m1": 0})
    assert edits.documents()["m1"] == answer.docs[0]
    assert TrackDoc.model_validate_json(answer.docs[0].model_dump_json()) == answer.docs[0]
    with edits.database.read() as session:
        assert session.scalars(select(Edit)).one().command["box"] == [0.1, 0.2, 0.7, 1e4 / 3]
