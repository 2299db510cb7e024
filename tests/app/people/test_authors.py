"""The account's name is the author on every route that stores a change; histories and statistics."""

from __future__ import annotations

import time
import uuid
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from sqlalchemy import update
from starlette.testclient import TestClient

from app.storage.migrations.versions.v0013_sums import fill
from app.storage.models import Edit
from tests.app.people.team import Team
from tests.app.toy_home import ToyHome
from tests.app.toy_server import Server


@pytest.fixture
def run(tracked_home: ToyHome) -> str:
    """A new run for edits."""
    run = tracked_home.add_run(folder=f"runs/{tracked_home.run_id}", parameters={}, tracks=2)
    with tracked_home.database.write() as session:
        tracked_home.events.publish(session, "run", run, {"state": "complete"})
    return run


def send(client: TestClient, run: str, author: str, revision: int = 0, **command: Any) -> Any:
    """Send an edit of track ``key``; returns the response."""
    body = {"op_id": uuid.uuid4().hex, "author": author, "command": {"frame": 5, **command}}
    headers = {"If-Match": f'"{command["key"]}:{revision}"'}
    return client.post(f"/api/runs/{run}/edits", json=body, headers=headers)


def keys_of(client: TestClient, run: str) -> list[str]:
    """Keys of the run's tracks."""
    return [f"m{number}" for number in client.get(f"/api/runs/{run}/tracks").json()["id"]]


def test_nobody_can_write_as_another_author(tracked_home: ToyHome, team_server: Server, team: Team, run: str) -> None:
    anna, adam = team.client("Anna"), team.client("Adam")
    key = keys_of(anna, run)[0]
    assert send(anna, run, "Anna", key=key, name="set_review", review="accepted").status_code == 200
    for client, other in ((anna, "Adam"), (adam, "Anna"), (anna, "anna"), (anna, "somebody")):
        answers = [
            send(client, run, other, 1, key=key, name="set_review", review="rejected"),
            client.post(f"/api/runs/{run}/adopt", json={"from_run": tracked_home.run_id, "author": other}),
            client.post(
                f"/api/runs/{run}/follows",
                json={"key": key, "anchors": [{"frame": 1, "box": [1, 1, 9, 9]}], "author": other},
            ),
            client.post(f"/api/videos/{tracked_home.video_id}/runs/by-hand", json={"author": other}),
            client.post(f"/api/runs/{run}/take-over", json={"truth": "0" * 32, "signs": [1], "author": other}),
            client.post(
                "/api/search/actions",
                json={
                    "action_id": uuid.uuid4().hex,
                    "action": {"type": "judge", "review": "accepted"},
                    "tracks": [{"run": run, "key": key, "revision": 0}],
                    "author": other,
                },
            ),
            client.post(
                "/api/search/undo", json={"operations": [{"run": run, "op_id": uuid.uuid4().hex}], "author": other}
            ),
        ]
        if client is adam:
            change = {"type": "add", "name": "x"}
            answers += [
                client.post("/api/label-sets/gtsrb-43/changes", json={"author": other, "change": change}),
                client.post("/api/label-sets/gtsrb-43/files", params={"author": other}, content=b"{}"),
                client.post("/api/bundles", params={"author": other}, content=b"x"),
                client.post(
                    f"/api/videos/{tracked_home.video_id}/imports", params={"as": "run", "author": other}, content=b"x"
                ),
            ]
        for answer in answers:
            assert (answer.status_code, answer.json()["error"]["code"]) == (403, "other_name"), answer.text
    log = anna.get(f"/api/runs/{run}/edits").json()["edits"]
    assert [row["author"] for row in log] == ["Anna"]


def test_the_account_name_is_the_default_author(team_server: Server, team: Team) -> None:
    answer = team.client("Rolf").post(
        "/api/label-sets/gtsrb-43/changes", json={"change": {"type": "add", "name": f"sign {uuid.uuid4().hex[:6]}"}}
    )
    assert answer.status_code == 200, answer.text
    newest = team_server.client.get("/api/label-sets/gtsrb-43/history").json()[0]
    assert newest["author"] == "Rolf"


def test_people_undo_only_their_own_edits(team: Team, run: str) -> None:
    anna, rolf = team.client("Anna"), team.client("Rolf")
    key = keys_of(anna, run)[0]
    op = send(anna, run, "Anna", key=key, name="set_review", review="accepted").json()["op_id"]
    assert anna.get(f"/api/runs/{run}/annotation", params={"author": "Rolf"}).json()["undo"]["op_id"] == op
    assert rolf.get(f"/api/runs/{run}/annotation", params={"author": "Anna"}).json()["undo"] is None
    assert rolf.get(f"/api/runs/{run}/follows", params={"author": "Anna"}).json() == {"found": None}


def test_a_note_gets_the_author_of_its_last_change(team: Team, run: str) -> None:
    anna, rolf = team.client("Anna"), team.client("Rolf")
    key = keys_of(anna, run)[0]
    send(anna, run, "Anna", key=key, name="add_note", note_id="n1", text="a scratch")
    changed = send(rolf, run, "Rolf", 1, key=key, name="edit_note", note_id="n1", text="a sign").json()
    assert [(note["author"], note["text"]) for note in changed["docs"][0]["notes"]] == [("Rolf", "a sign")]
    own = send(rolf, run, "Rolf", 2, key=key, name="edit_note", note_id="n1", text="a sign!").json()
    assert own["docs"][0]["notes"][0]["time"] == changed["docs"][0]["notes"][0]["time"]


def test_a_track_has_a_history(team: Team, run: str) -> None:
    anna, rolf = team.client("Anna"), team.client("Rolf")
    key, other = keys_of(anna, run)[:2]
    path = f"/api/runs/{run}/tracks/{key}/history"
    assert anna.get(path).json() == {"key": key, "happened": [], "more": None}
    send(anna, run, "Anna", key=key, name="relabel_track", class_id=3)
    send(anna, run, "Anna", key=other, name="set_review", review="rejected")
    op = send(rolf, run, "Rolf", 1, key=key, name="set_review", review="accepted").json()["op_id"]
    send(rolf, run, "Rolf", 2, key=key, name="set_box", box=[1.5, 2, 30, 40])
    send(rolf, run, "Rolf", 3, key=key, name="add_note", note_id="n1", text="bent")
    found = anna.get(path).json()["happened"]
    assert [(one["author"], one["name"]) for one in found] == [
        ("Rolf", "add_note"),
        ("Rolf", "set_box"),
        ("Rolf", "set_review"),
        ("Anna", "relabel_track"),
    ]
    told = [[(each["what"], each["before"], each["after"]) for each in one["differences"]] for one in found]
    assert told[3] == [("label", None, 3)]
    assert told[2] == [("review", "open", "accepted")]
    assert ("boxes", {}, {"5": [1.5, 2.0, 30.0, 40.0]}) in told[1]
    assert told[0] == [("notes", {}, {"n1": "Rolf, frame 5: bent"})]
    assert [one["seq"] for one in found] == sorted((one["seq"] for one in found), reverse=True)
    assert op
    # undone edits are history too, and many changes are paged
    for number in range(60):
        send(anna, run, "Anna", 4 + number, key=key, name="relabel_track", class_id=number % 7)
    first = anna.get(path).json()
    rest = anna.get(path, params={"before": first["more"]}).json()
    assert (len(first["happened"]), len(rest["happened"]), rest["more"]) == (50, 14, None)
    assert anna.get(f"/api/runs/{'0' * 32}/tracks/m1/history").status_code == 404


def test_statistics_of_a_person_and_overview(tracked_home: ToyHome, team_server: Server, team: Team, run: str) -> None:
    anna, rolf, vera = team.client("Anna"), team.client("Rolf"), team.client("Vera")
    first, second = keys_of(anna, run)[:2]
    send(anna, run, "Anna", key=first, name="set_review", review="accepted")
    send(anna, run, "Anna", key=second, name="set_review", review="rejected")
    send(rolf, run, "Rolf", 1, key=first, name="set_review", review="rejected")
    send(rolf, run, "Rolf", 1, key=second, name="set_review", review="rejected")
    undone = send(anna, run, "Anna", 2, key=second, name="set_review", review="accepted").json()["op_id"]
    body = {"op_id": uuid.uuid4().hex, "author": "Anna", "command": {"name": "undo", "op_id": undone}}
    assert anna.post(f"/api/runs/{run}/edits", json=body).status_code == 200
    send(rolf, run, "Rolf", 2, key=first, name="add_note", note_id="n1", text="?")
    send(rolf, run, "Rolf", 3, key=first, name="add_note", note_id="n2", text="two\nlines")

    own = anna.get("/api/people/Anna/activity").json()
    assert own["done"][0]["name"] == "undo"
    assert own["done"][0]["video_name"] == "drive.mp4"
    assert own["done"][0]["tracks"] == [second]
    assert own["worker"]["decided"] >= 2
    assert anna.get("/api/people/Rolf/activity").status_code == 403
    assert vera.get("/api/people/Vera/activity").json()["done"] == []
    assert rolf.get("/api/people/Anna/activity").json() == own
    assert rolf.get("/api/people/Eve/activity").status_code == 404
    older = rolf.get("/api/people/Anna/activity", params={"before": own["done"][0]["seq"]}).json()
    assert older["done"][0]["seq"] < own["done"][0]["seq"]

    assert anna.get("/api/overview").status_code == 403
    while (seen := rolf.get("/api/overview").json())["unread"]:
        time.sleep(0.05)  # the search tables are updated
    assert seen["tracks"] == 2
    assert (seen["reviewed"], seen["rejected"], seen["notes"]) == (2, 2, 2)
    assert seen["decided_twice"] >= 2
    assert seen["clocks"] is None
    people = {one["name"]: one for one in seen["people"]}
    assert people["Rolf"]["rejected"] >= 2
    assert people["Vera"] == {
        "name": "Vera",
        "role": "viewer",
        "decided": 0,
        "rejected": 0,
        "hours": 0.0,
        "assigned": 0,
        "in_review": 0,
    }


def test_a_wrong_clock_is_reported_and_does_not_affect_the_order(team_server: Server, team: Team, run: str) -> None:
    anna, rolf = team.client("Anna"), team.client("Rolf")
    key = keys_of(anna, run)[0]
    send(anna, run, "Anna", key=key, name="relabel_track", class_id=1)
    late = send(anna, run, "Anna", 1, key=key, name="relabel_track", class_id=2).json()["op_id"]
    with team_server.context.database.write() as session:
        tomorrow = datetime.now(UTC) + timedelta(days=1)
        session.execute(update(Edit).where(Edit.op_id == late).values(created=tomorrow))
        fill(session.connection())
    send(anna, run, "Anna", 2, key=key, name="relabel_track", class_id=3)
    seen = rolf.get("/api/overview").json()
    assert seen["clocks"].startswith("Clocks of servers differ, or were reset, by 14")
    assert all(one["hours"] < 1 for one in seen["people"])
    found = anna.get(f"/api/runs/{run}/tracks/{key}/history").json()["happened"]
    assert [one["differences"][0]["after"] for one in found] == [3, 2, 1]
    with team_server.context.database.write() as session:
        session.execute(update(Edit).where(Edit.op_id == late).values(created=datetime.now(UTC)))
        fill(session.connection())
