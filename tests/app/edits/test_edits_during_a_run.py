"""Edits of tracks that a run still extends."""

from __future__ import annotations

import pytest

from app.edits.commands import Undo
from app.edits.documents import OPEN_END
from app.edits.effective import box_at
from app.storage.models import Run
from tests.app.edits.edit_services import FRAMES, EditServices
from tests.app.edits.random_commands import engine_box
from tests.app.edits.sent_edits import relabel, send, undo_or_redo


def test_a_growing_track_stays_open_until_the_run_is_complete(edits: EditServices) -> None:
    with edits.database.write() as session:
        session.get_one(Run, edits.run).state = "running"
    doc = send(edits, "1", relabel(3), {"m1": 0}).docs[0]
    assert doc.segments[0].last == OPEN_END
    cut = send(edits, "2", {"name": "delete_from", "frame": 60, "key": "m3"}, {"m3": 0}).docs[0]
    assert cut.segments[0].last == 59
    edits.evidence.spans[1] = (0, 33)
    with edits.database.write() as session:
        session.get_one(Run, edits.run).state = "complete"
    doc = send(edits, "3", {"name": "set_review", "frame": 3, "key": "m1", "review": "accepted"}, {"m1": 1}).docs[0]
    assert doc.segments[0].last == 33
    undo_or_redo(edits, "4", Undo, "op-00000003")
    undo_or_redo(edits, "5", Undo, "op-00000002")
    undo_or_redo(edits, "6", Undo, "op-00000001")


@pytest.mark.parametrize(("key", "other"), [("m1", "m3"), ("m3", "m1"), ("m1", "hdrawn1")])
def test_a_merge_during_a_run_keeps_boxes_after_the_end_of_a_track(edits: EditServices, key: str, other: str) -> None:
    """m1 has ended at frame 20, but its document stays open until the run is complete."""
    with edits.database.write() as session:
        session.get_one(Run, edits.run).state = "running"
    send(edits, "1", {"name": "create_track", "frame": 60, "key": "hdrawn1", "box": [0, 0, 9, 9]}, {})
    revisions = {key: 0, other: int(other == "hdrawn1")}
    send(edits, "2", {"name": "merge", "frame": 60, "key": key, "others": [other]}, revisions)
    with edits.database.write() as session:
        session.get_one(Run, edits.run).state = "complete"
    answer = send(edits, "3", {"name": "set_review", "frame": 60, "key": key, "review": "accepted"}, {key: 1})
    boxes = {f for f in range(FRAMES) if box_at(answer.docs[0], f, engine_box)}
    assert boxes >= {0, 20 - 1, 60}
