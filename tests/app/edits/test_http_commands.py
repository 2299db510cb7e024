"""Every command over HTTP on a real run: applied, undone and redone; the invalid field is named."""

from __future__ import annotations

from typing import Any

import pytest

from tests.app.edits.edit_client import EditClient, error_of, if_match_header, relabel
from tests.app.toy_home import ToyHome
from tests.app.toy_server import Server

BOX = [10.0, 20.0, 40.0, 50.0]
GOOD: dict[str, dict[str, Any]] = {
    "create_track": {"key": "hfresh01", "box": BOX, "class_id": 14},
    "set_box": {"box": BOX},
    "relabel_track": {"class_id": 3},
    "relabel_box": {"class_id": 3, "box": BOX},
    "merge": {"others": ["m2"]},
    "split": {"new_key": "hlater01"},
    "delete_from": {},
    "delete_track": {},
    "add_key": {"box": BOX},
    "remove_key": {},
    "interpolate": {"first": 5, "last": 20, "value": True},
    "set_occluded": {"value": True, "box": BOX},
    "set_outside": {"value": True, "box": BOX},
    "set_not_a_sign": {"value": True},
    "ignore": {"value": True},
    "set_review": {"review": "accepted"},
    "review_tracks": {"others": ["m2"], "review": "accepted"},
    "add_note": {"note_id": "n1", "text": "<b>bold</b>"},
    "edit_note": {"note_id": "n1", "text": "plain"},
    "remove_note": {"note_id": "n1"},
}
NEEDS = {
    "remove_key": [{"name": "set_box", "box": BOX}],
    "edit_note": [{"name": "add_note", "note_id": "n1", "text": "x"}],
    "remove_note": [{"name": "add_note", "note_id": "n1", "text": "x"}],
    "interpolate": [{"name": "set_box", "box": BOX, "frame": 5}, {"name": "set_box", "box": BOX, "frame": 20}],
}


def command_of(name: str, tracks: list[str]) -> dict[str, Any]:
    command = {"name": name, "frame": 12, "key": tracks[0], **GOOD[name]}
    return {**command, **({"others": [tracks[1]]} if "others" in GOOD[name] else {})}


@pytest.mark.parametrize("name", GOOD)
def test_every_command_is_applied_undone_and_redone(ann: EditClient, tracks: list[str], name: str) -> None:
    for earlier in NEEDS.get(name, []):
        before = {"frame": 12, "key": tracks[0], **earlier}
        assert ann.send(before, if_match_header(ann, tracks)).status_code == 200
    start, rows = ann.docs(), len(ann.log())
    done = ann.send(command_of(name, tracks), if_match_header(ann, tracks), op="the-operation-" + ann.run)
    assert done.status_code == 200, done.text
    end = ann.docs()
    assert end != start
    assert done.json()["undo"]["op_id"] == done.json()["op_id"]
    undone = ann.send({"name": "undo", "op_id": done.json()["op_id"]})
    assert undone.status_code == 200, undone.text
    left = ann.docs()
    for key, doc in left.items():
        fresh = key not in start
        if fresh and key.startswith("h"):
            assert doc["gone"]
        elif fresh:
            assert (doc["keys"], doc["gone"], doc["class_id"], doc["notes"]) == ({}, False, None, [])
        else:
            assert doc == start[key]
    assert undone.json()["redo"]["op_id"] == done.json()["op_id"]
    assert ann.send({"name": "redo", "op_id": done.json()["op_id"]}).status_code == 200
    assert ann.docs() == end
    assert len(ann.log(after=0)) == rows + 3
    assert [row["name"] for row in ann.log()[-2:]] == ["undo", "redo"]


BROKEN: list[tuple[str, dict[str, Any], str]] = [
    *((name, {"frame": -1}, "command.frame") for name in GOOD),
    *((name, {"frame": 2**31}, "command.frame") for name in GOOD),
    *((name, {"frame": "1"}, "command.frame") for name in GOOD),
    *((name, {"key": "x1"}, "command.key") for name in GOOD),
    *((name, {"key": "m1\n"}, "command.key") for name in GOOD),
    *((name, {"surprise": 1}, "command.surprise") for name in GOOD),
    *((name, {"box": [4, 0, 3, 1]}, "command.box") for name, good in GOOD.items() if "box" in good),
    *((name, {"box": [0, 0, 1]}, "command.box.3") for name, good in GOOD.items() if "box" in good),
    *((name, {"box": [0, 0, "1", 1]}, "command.box.2") for name, good in GOOD.items() if "box" in good),
    ("ignore", {"value": 1}, "command.value"),
    ("attribute", {"attribute": "", "value": True}, "command.attribute"),
    ("attribute", {"attribute": "a", "value": [1]}, "command.value"),
    ("attribute", {"attribute": "a", "value": "nul \x00"}, "command.value"),
    ("attribute", {"attribute": "a", "value": "long" * 251}, "command.value"),
    ("attribute", {"attribute": "a", "value": True, "from_here": 1}, "command.from_here"),
    *((name, {"class_id": 2**31}, "command.class_id") for name, good in GOOD.items() if "class_id" in good),
    *((name, {"class_id": True}, "command.class_id") for name, good in GOOD.items() if "class_id" in good),
    *((name, {"value": 1}, "command.value") for name, good in GOOD.items() if "value" in good),
    *((name, {"note_id": ""}, "command.note_id") for name, good in GOOD.items() if "note_id" in good),
    *((name, {"text": "x" * 4001}, "command.text") for name, good in GOOD.items() if "text" in good),
    ("merge", {"others": []}, "command.others"),
    ("merge", {"others": ["m1; DROP TABLE edits"]}, "command.others.0"),
    ("split", {"new_key": "m3"}, "command.new_key"),
    ("set_review", {"review": "fine"}, "command.review"),
    ("review_tracks", {"review": "fine"}, "command.review"),
    ("review_tracks", {"others": [f"m{n}" for n in range(500)]}, "command.others"),
    ("interpolate", {"first": None}, "command.first"),
    ("explode", {}, "command"),
]


@pytest.mark.parametrize(("name", "broken", "field"), BROKEN, ids=lambda value: str(value)[:30])
def test_a_malformed_command_names_its_field(
    server: Server, tracked_home: ToyHome, name: str, broken: dict[str, Any], field: str
) -> None:
    page = EditClient(server, tracked_home.run_id)
    command = {"name": name, "frame": 12, "key": "m1", **GOOD.get(name, {}), **broken}
    answer = page.send(command, '"m1:0"')
    assert answer.status_code == 422, answer.text
    error = answer.json()["error"]
    assert error["field"] == field
    assert error["message"].startswith(field.split(".")[0])
    assert "value error" not in error["message"].lower()


@pytest.mark.parametrize(
    ("command", "field", "kind"),
    [
        *(
            ({"name": name, **good, "class_id": 43}, "class_id", "label")
            for name, good in GOOD.items()
            if "class_id" in good
        ),
        ({"name": "attribute", "attribute": "a", "value": True}, "attribute", "attribute"),
    ],
)
def test_unknown_labels_and_attributes_are_refused(
    server: Server, tracked_home: ToyHome, command: dict[str, Any], field: str, kind: str
) -> None:
    answer = EditClient(server, tracked_home.run_id).send({"frame": 12, "key": "m1", **command}, '"m1:0"')
    assert answer.status_code == 422, answer.text
    error = answer.json()["error"]
    assert (error["field"], error["code"]) == (f"command.{field}", f"no_such_{kind}")


@pytest.mark.parametrize("tag", ["m1:0", '"m1"', '"m1:x"', "*", '"m1:0" "m2:0"', '"x1:0"', '"m1:-1"', ""])
def test_a_malformed_precondition(ann: EditClient, tag: str) -> None:
    answer = ann.send(relabel("m1", 1), tag)
    assert answer.status_code == 422
    assert answer.json()["error"]["field"] == "if-match"


def test_impossible_commands_are_refused(ann: EditClient, tracks: list[str]) -> None:
    known = if_match_header(ann, tracks)
    for command in (
        relabel("m999999", 1),
        {"name": "remove_key", "frame": 3, "key": tracks[0]},
        {"name": "remove_note", "frame": 3, "key": tracks[0], "note_id": "none"},
        {"name": "merge", "frame": 3, "key": tracks[0], "others": [tracks[0]]},
    ):
        assert error_of(ann.send(command, known)) == (422, "impossible"), command
    assert ann.log() == []
