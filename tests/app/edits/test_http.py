"""Edits as a page makes them: over HTTP, on a real run."""

from __future__ import annotations

import sys
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

import toy_home
from databases import new_database
from toy_server import Server

BOX = [10.0, 20.0, 40.0, 50.0]


class Page:
    """What one person's page does."""

    def __init__(self, server: Server, run: str, author: str = "ann") -> None:
        self.client, self.run, self.author = server.client, run, author

    def send(self, command: dict[str, Any], match: str | None = None, op: str | None = None) -> Any:
        headers = {} if match is None else {"If-Match": match}
        body = {"op_id": op or uuid.uuid4().hex, "author": self.author, "command": command}
        return self.client.post(f"/api/runs/{self.run}/edits", json=body, headers=headers)

    def annotation(self) -> Any:
        answer = self.client.get(f"/api/runs/{self.run}/annotation", params={"author": self.author})
        assert answer.status_code == 200
        return answer.json()

    def docs(self) -> dict[str, Any]:
        """Documents without what every operation raises."""
        return {doc["key"]: {**doc, "revision": 0} for doc in self.annotation()["docs"]}

    def log(self, after: int = 0) -> list[Any]:
        rows: list[Any] = self.client.get(f"/api/runs/{self.run}/edits", params={"after": after}).json()["edits"]
        return rows


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[toy_home.ToyHome]:
    """One tracked toy drive for all tests here, on each kind of database."""
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "postgresql":
            patch.setenv("TSR_DATABASE_URL", new_database(request.getfixturevalue("cluster")))
        home = toy_home.make_home(tmp_path_factory.mktemp("http"))
        yield home
        home.evidence.close()
        home.database.close()


@pytest.fixture(scope="module")
def http(made: toy_home.ToyHome) -> Iterator[Server]:
    """A server on it; its database is the one that the environment names."""
    server = Server(made.settings.home, roots=(made.video.parent,))
    with server.client:
        yield server


@pytest.fixture
def run(made: toy_home.ToyHome) -> str:
    """A fresh run with the evidence of the first: edits belong to a run."""
    return made.add_run(folder=f"runs/{made.run_id}", parameters={}, tracks=2)


@pytest.fixture
def ann(http: Server, run: str) -> Page:
    """A person."""
    return Page(http, run)


@pytest.fixture
def tracks(http: Server, run: str) -> list[str]:
    """Keys of the run's tracks."""
    found = [f"m{number}" for number in http.client.get(f"/api/runs/{run}/tracks").json()["id"]]
    assert len(found) >= 2
    return found


def relabel(key: str, label: int | None) -> dict[str, Any]:
    return {"name": "relabel_track", "frame": 5, "key": key, "class_id": label}


def code(answer: Any) -> tuple[int, str]:
    return answer.status_code, answer.json()["error"]["code"]


def test_no_revision_no_edit(ann: Page, tracks: list[str]) -> None:
    answer = ann.send(relabel(tracks[0], 3))
    assert code(answer) == (428, "precondition_required")
    assert f'"{tracks[0]}:0"' in answer.json()["error"]["message"]
    assert code(ann.send(relabel(tracks[0], 3), f'"{tracks[1]}:0"'))[0] == 428
    assert ann.log() == []
    answer = ann.send(relabel(tracks[0], 3), f'"{tracks[0]}:0"')
    assert answer.status_code == 200
    doc = answer.json()["docs"][0]
    assert (doc["key"], doc["revision"], doc["class_id"]) == (tracks[0], 1, 3)


def test_stale_tells_both_versions_and_changes_nothing(http: Server, ann: Page, tracks: list[str]) -> None:
    bob = Page(http, ann.run, "bob")
    key = tracks[0]
    assert ann.send(relabel(key, 3), f'"{key}:0"').status_code == 200
    answer = bob.send(relabel(key, 7), f'"{key}:0"')
    assert code(answer) == (409, "stale")
    details = answer.json()["error"]["details"]
    assert [(doc["key"], doc["revision"], doc["class_id"]) for doc in details["current"]] == [(key, 1, 3)]
    assert [(doc["key"], doc["class_id"]) for doc in details["yours"]] == [(key, 7)]
    assert {name: (one["author"], one["name"]) for name, one in details["by"].items()} == {
        key: ("ann", "relabel_track")
    }
    assert details["by"][key]["time"][:19] == ann.log()[0]["time"][:19]
    assert ann.docs()[key]["class_id"] == 3
    # bob looks at both and decides for his own
    assert bob.send(relabel(key, 7), f'"{key}:1"').status_code == 200
    assert [row["author"] for row in ann.log()] == ["ann", "bob"]


def test_who_was_first_is_the_last_who_said_something_of_that_track(http: Server, ann: Page, tracks: list[str]) -> None:
    bob, eve = Page(http, ann.run, "bob"), Page(http, ann.run, "eve")
    assert ann.send(relabel(tracks[0], 3), f'"{tracks[0]}:0"').status_code == 200
    assert bob.send(relabel(tracks[1], 3), f'"{tracks[1]}:0"').status_code == 200
    merge = {"name": "merge", "frame": 0, "key": tracks[0], "others": [tracks[1]]}
    answer = eve.send(merge, f'"{tracks[0]}:0", "{tracks[1]}:0"')
    assert code(answer) == (409, "stale")
    by = answer.json()["error"]["details"]["by"]
    assert {name: one["author"] for name, one in by.items()} == {tracks[0]: "ann", tracks[1]: "bob"}


def test_two_pages_on_different_tracks_do_not_meet(http: Server, ann: Page, tracks: list[str]) -> None:
    bob = Page(http, ann.run, "bob")
    for step in range(3):
        assert ann.send(relabel(tracks[0], step), f'"{tracks[0]}:{step}"').status_code == 200
        assert bob.send(relabel(tracks[1], step), f'"{tracks[1]}:{step}"').status_code == 200
    assert {key: doc["class_id"] for key, doc in ann.docs().items()} == {tracks[0]: 2, tracks[1]: 2}


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


def match_of(page: Page, tracks: list[str]) -> str:
    known = {**dict.fromkeys(tracks, 0), **{doc["key"]: doc["revision"] for doc in page.annotation()["docs"]}}
    return ", ".join(f'"{key}:{revision}"' for key, revision in known.items())


@pytest.mark.parametrize("name", GOOD)
def test_every_command_is_taken_undone_and_redone(ann: Page, tracks: list[str], name: str) -> None:
    for earlier in NEEDS.get(name, []):
        before = {"frame": 12, "key": tracks[0], **earlier}
        assert ann.send(before, match_of(ann, tracks)).status_code == 200
    start, rows = ann.docs(), len(ann.log())
    done = ann.send(command_of(name, tracks), match_of(ann, tracks), op="the-operation-" + ann.run)
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
    *((name, {"class_id": 43}, "command.class_id") for name, good in GOOD.items() if "class_id" in good),
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
    http: Server, made: toy_home.ToyHome, name: str, broken: dict[str, Any], field: str
) -> None:
    page = Page(http, made.run_id)
    command = {"name": name, "frame": 12, "key": "m1", **GOOD.get(name, {}), **broken}
    answer = page.send(command, '"m1:0"')
    assert answer.status_code == 422, answer.text
    error = answer.json()["error"]
    assert error["field"] == field
    assert error["message"].startswith(field.split(".")[0])
    assert "value error" not in error["message"].lower()


@pytest.mark.parametrize("tag", ["m1:0", '"m1"', '"m1:x"', "*", '"m1:0" "m2:0"', '"x1:0"', '"m1:-1"', ""])
def test_a_malformed_precondition(ann: Page, tag: str) -> None:
    answer = ann.send(relabel("m1", 1), tag)
    assert answer.status_code == 422
    assert answer.json()["error"]["field"] == "if-match"


def test_commands_that_make_no_sense_are_told(ann: Page, tracks: list[str]) -> None:
    known = match_of(ann, tracks)
    for command in (
        relabel("m999999", 1),
        {"name": "remove_key", "frame": 3, "key": tracks[0]},
        {"name": "remove_note", "frame": 3, "key": tracks[0], "note_id": "none"},
        {"name": "merge", "frame": 3, "key": tracks[0], "others": [tracks[0]]},
    ):
        assert code(ann.send(command, known)) == (422, "impossible"), command
    assert ann.log() == []


def test_the_same_operation_twice_is_one_row(ann: Page, tracks: list[str]) -> None:
    op, command = uuid.uuid4().hex, relabel(tracks[0], 9)
    first = ann.send(command, f'"{tracks[0]}:0"', op)
    again = ann.send(command, f'"{tracks[0]}:0"', op)  # the answer to the first was lost on the way
    assert first.status_code == again.status_code == 200
    assert first.json() == again.json()
    assert len(ann.log()) == 1
    back = {"name": "undo", "op_id": op}
    op = uuid.uuid4().hex
    assert ann.send(back, op=op).json() == ann.send(back, op=op).json()
    assert [row["name"] for row in ann.log()] == ["relabel_track", "undo"]


def test_an_op_id_of_another_run_is_refused(http: Server, made: toy_home.ToyHome, ann: Page, tracks: list[str]) -> None:
    op = uuid.uuid4().hex
    assert ann.send(relabel(tracks[0], 9), f'"{tracks[0]}:0"', op).status_code == 200
    elsewhere = Page(http, made.add_run(folder=f"runs/{made.run_id}"))
    assert code(elsewhere.send(relabel(tracks[0], 9), f'"{tracks[0]}:0"', op)) == (409, "op_id_used")


def test_what_can_be_undone_survives_and_is_each_ones_own(http: Server, ann: Page, tracks: list[str]) -> None:
    bob = Page(http, ann.run, "bob")
    first = ann.send(relabel(tracks[0], 1), f'"{tracks[0]}:0"').json()["op_id"]
    second = ann.send(relabel(tracks[0], 2), f'"{tracks[0]}:1"').json()["op_id"]
    other = bob.send(relabel(tracks[1], 3), f'"{tracks[1]}:0"').json()["op_id"]
    assert ann.annotation()["undo"]["op_id"] == second
    assert bob.annotation()["undo"]["op_id"] == other
    assert code(ann.send({"name": "undo", "op_id": first})) == (409, "not_next")
    assert code(ann.send({"name": "undo", "op_id": other})) == (409, "not_next")
    assert ann.send({"name": "undo", "op_id": second}).status_code == 200
    assert ann.send({"name": "undo", "op_id": first}).status_code == 200
    assert ann.annotation()["undo"] is None
    assert ann.annotation()["redo"]["op_id"] == first
    # something new: what was undone is history
    ann.send(relabel(tracks[1], 4), f'"{tracks[1]}:1"')
    mine = ann.send(relabel(tracks[0], 5), f'"{tracks[0]}:4"').json()["op_id"]
    assert ann.annotation()["redo"] is None
    # bob's change over it makes it impossible to undo, and does not bar the way to what came before
    over = bob.send(relabel(tracks[0], 6), f'"{tracks[0]}:5"').json()["op_id"]
    answer = ann.send({"name": "undo", "op_id": mine})
    assert code(answer) == (409, "stale")
    assert answer.json()["error"]["message"] == f"bob has changed track {tracks[0]} since. Undo would lose that."
    assert answer.json()["error"]["details"]["current"][0]["class_id"] == 6
    before = ann.annotation()["undo"]
    assert (before["name"], before["keys"]) == ("relabel_track", [tracks[1]])
    assert ann.send({"name": "undo", "op_id": before["op_id"]}).status_code == 200
    assert ann.docs()[tracks[1]]["class_id"] == 3
    assert (ann.annotation()["undo"], ann.annotation()["redo"]["op_id"]) == (None, before["op_id"])
    # once bob takes his back, it is the next again
    assert bob.send({"name": "undo", "op_id": over}).status_code == 200
    assert ann.annotation()["undo"]["op_id"] == mine


def test_every_edit_is_in_the_stream(http: Server, ann: Page, tracks: list[str]) -> None:
    with http.context.database.read() as session:
        before = http.context.events.newest(session)
    ops = [ann.send(relabel(tracks[0], k), f'"{tracks[0]}:{k}"').json()["op_id"] for k in range(3)]
    ann.send({"name": "undo", "op_id": ops[-1]})
    ann.send(relabel(tracks[0], 9), f'"{tracks[0]}:0"')  # refused: nobody is told
    with http.context.database.read() as session:
        events = [event for event in http.context.events.after(session, before) if event.subject == ann.run]
    assert [event.kind for event in events] == ["edit"] * 4
    assert [event.data["op_id"] for event in events[:3]] == ops
    assert [event.data["docs"][0]["class_id"] for event in events] == [0, 1, 2, 1]
    assert [event.data["seq"] for event in events] == [row["seq"] for row in ann.log()]


def adopt(page: Page, from_run: str) -> Any:
    answer = page.client.post(f"/api/runs/{page.run}/adopt", json={"from_run": from_run, "author": page.author})
    assert answer.status_code == 200, answer.text
    return answer.json()


def test_edits_go_over_to_another_run_once(http: Server, made: toy_home.ToyHome, ann: Page, tracks: list[str]) -> None:
    new = Page(http, made.add_run(folder=f"runs/{made.run_id}"))
    assert adopt(new, ann.run) == {"kept": [], "not_needed": [], "conflicts": []}
    span = http.context.evidence.span(ann.run, int(tracks[0][1:]))
    assert span is not None
    ann.send(relabel(tracks[0], 7), f'"{tracks[0]}:0"')
    cut = (span[0] + span[1]) // 2
    ann.send({"name": "split", "frame": cut, "key": tracks[0], "new_key": "hlater01"}, f'"{tracks[0]}:1"')
    ann.send({"name": "delete_track", "frame": 1, "key": tracks[1]}, f'"{tracks[1]}:0"')
    drawn = {"name": "create_track", "frame": 3, "key": "hdrawn01", "box": [1.0, 1.0, 9.0, 9.0], "class_id": 2}
    assert ann.send(drawn, "").status_code == 422
    assert ann.send(drawn).status_code == 200
    first = adopt(new, ann.run)
    assert sorted(first["kept"]) == sorted([tracks[0], tracks[1], "hlater01", "hdrawn01"])
    assert first["conflicts"] == []
    rows, docs = new.log(), new.docs()
    assert {row["name"] for row in rows} == {"adopt"}
    assert docs == ann.docs()
    # again, as after a lost answer or by a second person: the same, and nothing is written
    assert adopt(new, ann.run) == first
    assert (new.log(), new.docs()) == (rows, docs)
    # what somebody has changed since stays, and is told
    assert new.send(relabel(tracks[0], 8), f'"{tracks[0]}:1"').status_code == 200
    third = adopt(new, ann.run)
    assert [conflict["key"] for conflict in third["conflicts"]] == [tracks[0]]
    assert sorted(third["kept"]) == sorted([tracks[1], "hlater01", "hdrawn01"])
    assert new.docs()[tracks[0]]["class_id"] == 8
    # taken back: all is as the adoption has left it
    assert new.send({"name": "undo", "op_id": new.annotation()["undo"]["op_id"]}).status_code == 200
    assert adopt(new, ann.run) == first
    # an adopted edit can be taken back like any other, and come over once more
    assert new.send({"name": "undo", "op_id": new.annotation()["undo"]["op_id"]}).status_code == 200
    taken_back = [key for key, doc in new.docs().items() if doc != docs[key]]
    assert len(taken_back) == 1
    assert adopt(new, ann.run) == first
    assert new.docs() == docs


def test_what_is_new_since_the_first_adoption_comes_too(
    http: Server, made: toy_home.ToyHome, ann: Page, tracks: list[str]
) -> None:
    new = Page(http, made.add_run(folder=f"runs/{made.run_id}"))
    ann.send(relabel(tracks[0], 7), f'"{tracks[0]}:0"')
    assert adopt(new, ann.run)["kept"] == [tracks[0]]
    ann.send(relabel(tracks[1], 4), f'"{tracks[1]}:0"')
    assert sorted(adopt(new, ann.run)["kept"]) == sorted(tracks[:2])
    assert len(new.log()) == 2
    ann.send(relabel(tracks[1], 5), f'"{tracks[1]}:1"')
    assert sorted(adopt(new, ann.run)["kept"]) == sorted(tracks[:2])
    assert new.docs()[tracks[1]]["class_id"] == 5
    assert len(new.log()) == 3


def test_adopting_from_nowhere(http: Server, made: toy_home.ToyHome, ann: Page) -> None:
    for source, status in (("0" * 32, 404), (ann.run, 422), ("x", 422)):
        answer = ann.client.post(f"/api/runs/{ann.run}/adopt", json={"from_run": source})
        assert answer.status_code == status
    waiting = made.add_run(state="running")
    answer = ann.client.post(f"/api/runs/{waiting}/adopt", json={"from_run": ann.run})
    assert code(answer) == (409, "run_not_complete")


def test_unknown_runs_are_not_found(http: Server) -> None:
    page = Page(http, "0" * 32)
    assert page.send(relabel("m1", 1), '"m1:0"').status_code == 404
    assert http.client.get(f"/api/runs/{page.run}/annotation").status_code == 404
    assert http.client.get(f"/api/runs/{page.run}/edits").status_code == 404
