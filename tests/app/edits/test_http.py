"""Edits of pages over HTTP on a real run: revisions, repetition, undo, adoption."""

from __future__ import annotations

import shutil
import sqlite3
import uuid
from pathlib import Path
from typing import Any

import pytest

from app.errors import Busy
from app.files.shared import ensure_local
from app.files.store import SharedFilesError
from app.settings import Settings
from tests.app.edits.edit_client import EditClient, error_of, relabel
from tests.app.toy_home import ToyHome
from tests.app.toy_server import Server
from tsr_engine.errors import StorageError


def test_an_edit_needs_a_revision(ann: EditClient, tracks: list[str]) -> None:
    answer = ann.send(relabel(tracks[0], 3))
    assert error_of(answer) == (428, "precondition_required")
    assert f'"{tracks[0]}:0"' in answer.json()["error"]["message"]
    assert error_of(ann.send(relabel(tracks[0], 3), f'"{tracks[1]}:0"'))[0] == 428
    assert ann.log() == []
    answer = ann.send(relabel(tracks[0], 3), f'"{tracks[0]}:0"')
    assert answer.status_code == 200
    doc = answer.json()["docs"][0]
    assert (doc["key"], doc["revision"], doc["class_id"]) == (tracks[0], 1, 3)


def test_a_stale_edit_returns_both_versions_and_changes_nothing(
    server: Server, ann: EditClient, tracks: list[str]
) -> None:
    bob = EditClient(server, ann.run, "bob")
    key = tracks[0]
    assert ann.send(relabel(key, 3), f'"{key}:0"').status_code == 200
    answer = bob.send(relabel(key, 7), f'"{key}:0"')
    assert error_of(answer) == (409, "stale")
    details = answer.json()["error"]["details"]
    assert [(doc["key"], doc["revision"], doc["class_id"]) for doc in details["current"]] == [(key, 1, 3)]
    assert [(doc["key"], doc["class_id"]) for doc in details["yours"]] == [(key, 7)]
    assert {name: (one["author"], one["name"]) for name, one in details["by"].items()} == {
        key: ("ann", "relabel_track")
    }
    assert details["by"][key]["time"][:19] == ann.log()[0]["time"][:19]
    assert ann.docs()[key]["class_id"] == 3
    # bob compares both and chooses his own
    assert bob.send(relabel(key, 7), f'"{key}:1"').status_code == 200
    assert [row["author"] for row in ann.log()] == ["ann", "bob"]


def test_a_stale_edit_names_the_last_author_of_the_track(server: Server, ann: EditClient, tracks: list[str]) -> None:
    bob, eve = EditClient(server, ann.run, "bob"), EditClient(server, ann.run, "eve")
    assert ann.send(relabel(tracks[0], 3), f'"{tracks[0]}:0"').status_code == 200
    assert bob.send(relabel(tracks[1], 3), f'"{tracks[1]}:0"').status_code == 200
    merge = {"name": "merge", "frame": 0, "key": tracks[0], "others": [tracks[1]]}
    answer = eve.send(merge, f'"{tracks[0]}:0", "{tracks[1]}:0"')
    assert error_of(answer) == (409, "stale")
    by = answer.json()["error"]["details"]["by"]
    assert {name: one["author"] for name, one in by.items()} == {tracks[0]: "ann", tracks[1]: "bob"}


def test_two_pages_on_different_tracks_do_not_conflict(server: Server, ann: EditClient, tracks: list[str]) -> None:
    bob = EditClient(server, ann.run, "bob")
    for step in range(3):
        assert ann.send(relabel(tracks[0], step), f'"{tracks[0]}:{step}"').status_code == 200
        assert bob.send(relabel(tracks[1], step), f'"{tracks[1]}:{step}"').status_code == 200
    assert {key: doc["class_id"] for key, doc in ann.docs().items()} == {tracks[0]: 2, tracks[1]: 2}


def test_the_same_operation_twice_is_one_row(ann: EditClient, tracks: list[str]) -> None:
    op, command = uuid.uuid4().hex, relabel(tracks[0], 9)
    first = ann.send(command, f'"{tracks[0]}:0"', op)
    again = ann.send(command, f'"{tracks[0]}:0"', op)  # the answer to the first was lost
    assert first.status_code == again.status_code == 200
    assert first.json() == again.json()
    assert len(ann.log()) == 1
    back = {"name": "undo", "op_id": op}
    op = uuid.uuid4().hex
    assert ann.send(back, op=op).json() == ann.send(back, op=op).json()
    assert [row["name"] for row in ann.log()] == ["relabel_track", "undo"]


def test_an_op_id_of_another_run_is_refused(
    server: Server, tracked_home: ToyHome, ann: EditClient, tracks: list[str]
) -> None:
    op = uuid.uuid4().hex
    assert ann.send(relabel(tracks[0], 9), f'"{tracks[0]}:0"', op).status_code == 200
    elsewhere = EditClient(server, tracked_home.add_run(folder=f"runs/{tracked_home.run_id}"))
    assert error_of(elsewhere.send(relabel(tracks[0], 9), f'"{tracks[0]}:0"', op)) == (409, "op_id_used")


def test_undo_targets_persist_and_are_per_person(server: Server, ann: EditClient, tracks: list[str]) -> None:
    bob = EditClient(server, ann.run, "bob")
    first = ann.send(relabel(tracks[0], 1), f'"{tracks[0]}:0"').json()["op_id"]
    second = ann.send(relabel(tracks[0], 2), f'"{tracks[0]}:1"').json()["op_id"]
    other = bob.send(relabel(tracks[1], 3), f'"{tracks[1]}:0"').json()["op_id"]
    assert ann.annotation()["undo"]["op_id"] == second
    assert bob.annotation()["undo"]["op_id"] == other
    assert error_of(ann.send({"name": "undo", "op_id": first})) == (409, "not_next")
    assert error_of(ann.send({"name": "undo", "op_id": other})) == (409, "not_next")
    assert ann.send({"name": "undo", "op_id": second}).status_code == 200
    assert ann.send({"name": "undo", "op_id": first}).status_code == 200
    assert ann.annotation()["undo"] is None
    assert ann.annotation()["redo"]["op_id"] == first
    # a new edit: redo is no longer possible
    ann.send(relabel(tracks[1], 4), f'"{tracks[1]}:1"')
    own_op = ann.send(relabel(tracks[0], 5), f'"{tracks[0]}:4"').json()["op_id"]
    assert ann.annotation()["redo"] is None
    # bob's later change makes it impossible to undo, but not the edits before it
    over = bob.send(relabel(tracks[0], 6), f'"{tracks[0]}:5"').json()["op_id"]
    answer = ann.send({"name": "undo", "op_id": own_op})
    assert error_of(answer) == (409, "stale")
    assert answer.json()["error"]["message"] == f"bob has changed track {tracks[0]} since. Undo would lose that."
    assert answer.json()["error"]["details"]["current"][0]["class_id"] == 6
    before = ann.annotation()["undo"]
    assert (before["name"], before["keys"]) == ("relabel_track", [tracks[1]])
    assert ann.send({"name": "undo", "op_id": before["op_id"]}).status_code == 200
    assert ann.docs()[tracks[1]]["class_id"] == 3
    assert (ann.annotation()["undo"], ann.annotation()["redo"]["op_id"]) == (None, before["op_id"])
    # once bob undoes his, it is the next target again
    assert bob.send({"name": "undo", "op_id": over}).status_code == 200
    assert ann.annotation()["undo"]["op_id"] == own_op


def test_every_edit_is_in_the_stream(server: Server, ann: EditClient, tracks: list[str]) -> None:
    with server.context.database.read() as session:
        before = server.context.events.newest(session)
    ops = [ann.send(relabel(tracks[0], k), f'"{tracks[0]}:{k}"').json()["op_id"] for k in range(3)]
    ann.send({"name": "undo", "op_id": ops[-1]})
    ann.send(relabel(tracks[0], 9), f'"{tracks[0]}:0"')  # refused: no event
    with server.context.database.read() as session:
        events = [event for event in server.context.events.after(session, before) if event.subject == ann.run]
    assert [event.kind for event in events] == ["edit"] * 4
    assert [event.data["op_id"] for event in events[:3]] == ops
    assert [event.data["docs"][0]["class_id"] for event in events] == [0, 1, 2, 1]
    assert [event.data["seq"] for event in events] == [row["seq"] for row in ann.log()]


def adopt_edits(page: EditClient, from_run: str) -> Any:
    answer = page.client.post(f"/api/runs/{page.run}/adopt", json={"from_run": from_run, "author": page.author})
    assert answer.status_code == 200, answer.text
    return answer.json()


def test_edits_are_adopted_by_another_run_once(
    server: Server, tracked_home: ToyHome, ann: EditClient, tracks: list[str]
) -> None:
    new = EditClient(server, tracked_home.add_run(folder=f"runs/{tracked_home.run_id}"))
    assert adopt_edits(new, ann.run) == {"kept": [], "not_needed": [], "conflicts": []}
    span = server.context.evidence.span(ann.run, int(tracks[0][1:]))
    assert span is not None
    ann.send(relabel(tracks[0], 7), f'"{tracks[0]}:0"')
    cut = (span[0] + span[1]) // 2
    ann.send({"name": "split", "frame": cut, "key": tracks[0], "new_key": "hlater01"}, f'"{tracks[0]}:1"')
    ann.send({"name": "delete_track", "frame": 1, "key": tracks[1]}, f'"{tracks[1]}:0"')
    drawn = {"name": "create_track", "frame": 3, "key": "hdrawn01", "box": [1.0, 1.0, 9.0, 9.0], "class_id": 2}
    assert ann.send(drawn, "").status_code == 422
    assert ann.send(drawn).status_code == 200
    first = adopt_edits(new, ann.run)
    assert sorted(first["kept"]) == sorted([tracks[0], tracks[1], "hlater01", "hdrawn01"])
    assert first["conflicts"] == []
    rows, docs = new.log(), new.docs()
    assert {row["name"] for row in rows} == {"adopt"}
    assert docs == ann.docs()
    # a repetition, after a lost answer or by a second person, writes nothing
    assert adopt_edits(new, ann.run) == first
    assert (new.log(), new.docs()) == (rows, docs)
    # later changes stay and are reported
    assert new.send(relabel(tracks[0], 8), f'"{tracks[0]}:1"').status_code == 200
    third = adopt_edits(new, ann.run)
    assert [conflict["key"] for conflict in third["conflicts"]] == [tracks[0]]
    assert sorted(third["kept"]) == sorted([tracks[1], "hlater01", "hdrawn01"])
    assert new.docs()[tracks[0]]["class_id"] == 8
    # undone: the state after the adoption
    assert new.send({"name": "undo", "op_id": new.annotation()["undo"]["op_id"]}).status_code == 200
    assert adopt_edits(new, ann.run) == first
    # an adopted edit can be undone like any other, and adopted again
    assert new.send({"name": "undo", "op_id": new.annotation()["undo"]["op_id"]}).status_code == 200
    undone_operations = [key for key, doc in new.docs().items() if doc != docs[key]]
    assert len(undone_operations) == 1
    assert adopt_edits(new, ann.run) == first
    assert new.docs() == docs


def test_later_edits_are_adopted_too(server: Server, tracked_home: ToyHome, ann: EditClient, tracks: list[str]) -> None:
    new = EditClient(server, tracked_home.add_run(folder=f"runs/{tracked_home.run_id}"))
    ann.send(relabel(tracks[0], 7), f'"{tracks[0]}:0"')
    assert adopt_edits(new, ann.run)["kept"] == [tracks[0]]
    ann.send(relabel(tracks[1], 4), f'"{tracks[1]}:0"')
    assert sorted(adopt_edits(new, ann.run)["kept"]) == sorted(tracks[:2])
    assert len(new.log()) == 2
    ann.send(relabel(tracks[1], 5), f'"{tracks[1]}:1"')
    assert sorted(adopt_edits(new, ann.run)["kept"]) == sorted(tracks[:2])
    assert new.docs()[tracks[1]]["class_id"] == 5
    assert len(new.log()) == 3


def test_undone_edits_of_the_new_run_do_not_block_adoption(
    server: Server, tracked_home: ToyHome, ann: EditClient, tracks: list[str]
) -> None:
    new = EditClient(server, tracked_home.add_run(folder=f"runs/{tracked_home.run_id}"))
    ann.send(relabel(tracks[0], 7), f'"{tracks[0]}:0"')
    made_there = new.send(relabel(tracks[0], 9), f'"{tracks[0]}:0"').json()
    assert [conflict["key"] for conflict in adopt_edits(new, ann.run)["conflicts"]] == [tracks[0]]
    new.send({"name": "undo", "op_id": made_there["op_id"]})
    assert adopt_edits(new, ann.run) == {"kept": [tracks[0]], "not_needed": [], "conflicts": []}
    assert new.docs()[tracks[0]]["class_id"] == 7


def test_adopting_from_an_unknown_run_is_refused(server: Server, tracked_home: ToyHome, ann: EditClient) -> None:
    for source, status in (("0" * 32, 404), (ann.run, 422), ("x", 422)):
        answer = ann.client.post(f"/api/runs/{ann.run}/adopt", json={"from_run": source})
        assert answer.status_code == status
    waiting = tracked_home.add_run(state="running")
    answer = ann.client.post(f"/api/runs/{waiting}/adopt", json={"from_run": ann.run})
    assert error_of(answer) == (409, "run_not_complete")


def test_unknown_runs_are_not_found(server: Server) -> None:
    page = EditClient(server, "0" * 32)
    assert page.send(relabel("m1", 1), '"m1:0"').status_code == 404
    assert server.client.get(f"/api/runs/{page.run}/annotation").status_code == 404
    assert server.client.get(f"/api/runs/{page.run}/edits").status_code == 404


def earlier_runs(page: EditClient) -> Any:
    answer = page.client.get(f"/api/runs/{page.run}/earlier")
    assert answer.status_code == 200, answer.text
    return answer.json()["found"]


def test_a_later_run_lists_missing_corrections(
    server: Server, tracked_home: ToyHome, ann: EditClient, tracks: list[str]
) -> None:
    ann.send(relabel(tracks[0], 7), f'"{tracks[0]}:0"')
    ann.send({"name": "set_review", "frame": 1, "key": tracks[1], "review": "accepted"}, f'"{tracks[1]}:0"')
    new = EditClient(server, tracked_home.add_run(folder=f"runs/{tracked_home.run_id}"))
    assert earlier_runs(new) == {"run_id": ann.run, "tracks": 2, "seq": ann.log()[-1]["seq"]}
    assert (earlier_runs(ann) or {}).get("run_id") != new.run, "nothing comes from a later run"
    adopt_edits(new, ann.run)
    assert earlier_runs(new) is None
    ann.send(relabel(tracks[0], 8), f'"{tracks[0]}:1"')
    assert earlier_runs(new)["tracks"] == 2, "what is new there is worth telling again"
    whatif = EditClient(server, tracked_home.add_run(folder=f"runs/{tracked_home.run_id}", kind="whatif"))
    assert earlier_runs(whatif) is None


def test_missing_evidence_of_another_run_is_ignored(
    server: Server, tracked_home: ToyHome, ann: EditClient, tracks: list[str]
) -> None:
    ann.send(relabel(tracks[0], 7), f'"{tracks[0]}:0"')
    lost = EditClient(server, tracked_home.add_run())
    folder = tracked_home.settings.home / "runs" / lost.run
    shutil.copytree(tracked_home.folder, folder)
    assert lost.send(relabel(tracks[0], 7), f'"{tracks[0]}:0"').status_code == 200
    shutil.rmtree(folder)
    new = EditClient(server, tracked_home.add_run(folder=f"runs/{tracked_home.run_id}"))
    assert earlier_runs(new)["run_id"] == ann.run
    assert server.client.get(f"/api/runs/{new.run}/tracks").status_code == 200
    answer = server.client.get(f"/api/runs/{lost.run}/tracks")
    assert answer.json()["error"]["code"] == "evidence_gone"
    server.client.delete(f"/api/runs/{lost.run}")


@pytest.mark.parametrize(
    "reason",
    [
        Busy("Still being fetched.", code="files_coming"),
        SharedFilesError("No answer.", code="files_away"),
        StorageError("Full."),
    ],
)
def test_another_run_that_cannot_be_fetched_is_ignored_until_it_is_there(
    server: Server,
    tracked_home: ToyHome,
    ann: EditClient,
    tracks: list[str],
    monkeypatch: pytest.MonkeyPatch,
    reason: Exception,
) -> None:
    folder = f"runs/{tracked_home.run_id}"
    ann.send(relabel(tracks[0], 7), f'"{tracks[0]}:0"')
    away = EditClient(server, tracked_home.add_run())
    copy = tracked_home.settings.home / "runs" / away.run
    shutil.copytree(tracked_home.folder, copy)
    assert away.send(relabel(tracks[0], 7), f'"{tracks[0]}:0"').status_code == 200
    new = EditClient(server, tracked_home.add_run(folder=folder))
    with monkeypatch.context() as patch:

        def refuse(settings: Settings, place: str | None, name: str) -> Path:
            if away.run in name:
                raise reason
            return ensure_local(settings, place, name)

        patch.setattr("app.evidence.service.ensure_local", refuse)
        assert earlier_runs(new)["run_id"] == ann.run
        alone = server.client.get(f"/api/runs/{new.run}/tracks")
        assert alone.status_code == 200
        assert server.client.get(f"/api/runs/{away.run}/tracks").status_code != 200
    with sqlite3.connect(copy / "evidence.sqlite") as evidence:
        evidence.execute("update tracks set class_id = (class_id + 1) % 43")
    assert earlier_runs(new)["run_id"] == away.run
    assert "labels it" not in alone.text
    assert "labels it" in server.client.get(f"/api/runs/{new.run}/tracks").text
    server.client.delete(f"/api/runs/{away.run}")


def test_undone_edits_are_not_corrections(server: Server, tracked_home: ToyHome, tracks: list[str]) -> None:
    old = EditClient(server, tracked_home.add_run(folder=f"runs/{tracked_home.run_id}"))
    kept = old.send(relabel(tracks[0], 7), f'"{tracks[0]}:0"').json()
    new = EditClient(server, tracked_home.add_run(folder=f"runs/{tracked_home.run_id}"))
    assert earlier_runs(new)["run_id"] == old.run
    old.send({"name": "undo", "op_id": kept["op_id"]})
    assert (earlier_runs(new) or {}).get("run_id") != old.run


def test_earlier_corrections_of_an_unknown_run(server: Server) -> None:
    assert server.client.get(f"/api/runs/{'0' * 32}/earlier").status_code == 404
