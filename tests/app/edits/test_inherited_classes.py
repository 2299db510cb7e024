"""The classes of tracks that a split or a merge leaves."""

from __future__ import annotations

import pytest

from app.edits.commands import Redo, Undo
from tests.app.edits.edit_services import EditServices
from tests.app.edits.sent_edits import content, send, undo_or_redo


@pytest.mark.parametrize("reported", [{}, {"class_id": 2}])
def test_a_split_inherits_the_class_of_the_evidence(edits: EditServices, reported: dict[str, int]) -> None:
    send(edits, "1", {"name": "set_box", "frame": 30, "key": "m1", "box": [0.0, 0.0, 9.0, 9.0]}, {"m1": 0})
    whole = content(edits)
    split = {"name": "split", "frame": 25, "key": "m1", "new_key": "hlater01", **reported}
    docs = {doc.key: doc for doc in send(edits, "2", split, {"m1": 1}).docs}
    assert (docs["m1"].class_id, docs["hlater01"].class_id) == (None, 14)
    undo_or_redo(edits, "3", Undo, "op-00000002")
    assert content(edits) == whole
    again = {doc.key: doc for doc in undo_or_redo(edits, "4", Redo, "op-00000002").docs}
    assert again["hlater01"].class_id == 14
    # an unrecognised track has no class to inherit
    send(edits, "5", {"name": "set_box", "frame": 60, "key": "m2", "box": [0.0, 0.0, 9.0, 9.0]}, {"m2": 0})
    split = {"name": "split", "frame": 55, "key": "m2", "new_key": "hlater02", **reported}
    assert {doc.key: doc.class_id for doc in send(edits, "6", split, {"m2": 1}).docs} == {"m2": None, "hlater02": None}


@pytest.mark.parametrize("reported", [{}, {"class_id": 2}])
@pytest.mark.parametrize(("other", "label"), [("m1", 38), ("hlater02", None)])
def test_a_merge_keeps_the_label_that_the_track_showed(
    edits: EditServices, reported: dict[str, int], other: str, label: int | None
) -> None:
    """An earlier engine track into a part of m3, and a later part of the same track into it."""
    for step, (frame, key) in enumerate([(65, "hlater02"), (60, "hlater01")]):
        split = {"name": "split", "frame": frame, "key": "m3", "new_key": key}
        send(edits, f"{step}", split, {"m3": step})
    merge = {"name": "merge", "frame": 60, "key": "hlater01", "others": [other], **reported}
    revisions = {"hlater01": 1, other: int(other == "hlater02")}
    docs = {doc.key: doc for doc in send(edits, "2", merge, revisions).docs}
    assert docs["hlater01"].class_id == label
    assert docs[other].merged_into == "hlater01"
