"""Assignments: given, handed in, returned with a comment, done; and the roles that may change them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from starlette.testclient import TestClient

from app.storage.models import Video
from tests.app.people.team import Team
from tests.app.toy_home import ToyHome
from tests.app.toy_server import Server


@pytest.fixture(autouse=True)
def clean(team_server: Server, team: Team) -> Iterator[None]:
    """Assignments are removed with their people."""
    yield
    for one in team_server.client.get("/api/assignments").json()["assignments"]:
        assert team_server.client.delete(f"/api/assignments/{one['id']}").status_code == 204


def assign(client: TestClient, video: str, person: str = "Anna", **more: Any) -> Any:
    """Assign; returns the response."""
    return client.post("/api/assignments", json={"videos": [video], "person": person, **more})


def change(client: TestClient, known: Any, **what: Any) -> Any:
    """Change an assignment; returns the response."""
    return client.patch(f"/api/assignments/{known['id']}", json={"revision": known["revision"], **what})


def assert_refused(answer: Any, status: int, words: str) -> None:
    """Assert a refusal in one sentence."""
    assert answer.status_code == status, answer.text
    assert words in answer.json()["error"]["message"]


def test_states_of_an_assignment(tracked_home: ToyHome, team: Team) -> None:
    rolf, anna = team.client("Rolf"), team.client("Anna")
    (one,) = assign(rolf, tracked_home.video_id, comment="look at the far signs").json()["assignments"]
    assert (one["person"], one["state"], one["comment"], one["changed_by"]) == (
        "Anna",
        "assigned",
        "look at the far signs",
        "Rolf",
    )
    assert anna.get("/api/assignments", params={"person": "anna"}).json()["assignments"] == [one]
    handed = change(anna, one, state="in_review").json()
    assert (handed["state"], handed["revision"], handed["changed_by"]) == ("in_review", 2, "Anna")
    assert_refused(change(rolf, handed, state="returned"), 422, "what must be done again")
    assert_refused(change(rolf, handed, state="returned", comment="  "), 422, "what must be done again")
    back = change(rolf, handed, state="returned", comment="frame 12 lacks a box").json()
    assert (back["state"], back["comment"]) == ("returned", "frame 12 lacks a box")
    again = change(anna, back, state="in_review").json()
    assert again["comment"] == "frame 12 lacks a box"
    done = change(rolf, again, state="done").json()
    assert (done["state"], done["revision"]) == ("done", 5)
    assert rolf.get("/api/people").json()["people"][1] | {"created": ""} == {
        "name": "Anna",
        "role": "annotator",
        "created": "",
        "assignments": 0,
    }


def test_changes_need_permission(tracked_home: ToyHome, team_server: Server, team: Team) -> None:
    rolf, anna = team.client("Rolf"), team.client("Anna")
    team_server.context.people.set_role("Vera", "annotator")
    vera = team.client("Vera")
    (one,) = assign(rolf, tracked_home.video_id).json()["assignments"]
    assert_refused(assign(anna, tracked_home.video_id, "Vera"), 403, "Anna is an annotator")
    assert_refused(change(vera, one, state="in_review"), 403, "This is the work of Anna")
    assert_refused(change(anna, one, state="done"), 403, "Only a reviewer can make it done")
    assert_refused(change(anna, one, state="returned"), 403, "Only a reviewer")
    assert_refused(change(anna, one, person="Vera"), 403, "Only a reviewer can assign work")
    assert_refused(change(anna, one, comment="x", state="in_review"), 403, "Only a reviewer")
    assert_refused(anna.delete(f"/api/assignments/{one['id']}"), 403, "Anna is an annotator")
    moved = change(rolf, one, person="Vera").json()
    assert (moved["person"], moved["state"]) == ("Vera", "assigned")
    assert_refused(change(anna, moved, state="in_review"), 403, "This is the work of Vera")
    taken = change(vera, change(vera, moved, state="in_review").json(), state="assigned").json()
    assert taken["state"] == "assigned"


def test_a_simultaneous_change_is_refused(tracked_home: ToyHome, team: Team) -> None:
    rolf, anna = team.client("Rolf"), team.client("Anna")
    (one,) = assign(rolf, tracked_home.video_id).json()["assignments"]
    assert change(anna, one, state="in_review").status_code == 200
    answer = change(rolf, one, comment="hurry")
    assert_refused(answer, 409, "Anna has changed this assignment meanwhile: it is in review now.")
    assert answer.json()["error"]["details"]["current"]["state"] == "in_review"


def test_an_outdated_page_does_not_change_a_later_assignment(tracked_home: ToyHome, team: Team) -> None:
    rolf, anna = team.client("Rolf"), team.client("Anna")
    (one,) = assign(rolf, tracked_home.video_id, stop=40).json()["assignments"]
    assert rolf.delete(f"/api/assignments/{one['id']}").status_code == 204
    (later,) = assign(rolf, tracked_home.video_id, first=40).json()["assignments"]
    assert_refused(change(anna, one, state="in_review"), 404, "no such assignment")
    assert anna.get("/api/assignments").json()["assignments"] == [later]


def test_frames_of_a_video_go_to_several_people(tracked_home: ToyHome, team_server: Server, team: Team) -> None:
    rolf = team.client("Rolf")
    team_server.context.people.set_role("Vera", "annotator")
    assert assign(rolf, tracked_home.video_id, first=0, stop=40).status_code == 201
    assert assign(rolf, tracked_home.video_id, "Vera", first=40).status_code == 201
    assert_refused(
        assign(rolf, tracked_home.video_id, first=39, stop=60), 409, "Anna has drive.mp4 already, frames 0 to 39"
    )
    (last,) = assign(rolf, tracked_home.video_id, first=40, stop=75).json()["assignments"]
    assert_refused(change(rolf, last, person="Vera"), 409, "Vera has drive.mp4 already, from frame 40")
    last = change(rolf, last, person="Anna").json()
    assert (last["person"], last["revision"]) == ("Anna", 2)
    for first, stop in ((0, 76), (75, None), (5, 5), (9, 3)):
        assert_refused(assign(rolf, tracked_home.video_id, "Adam", first=first, stop=stop), 422, "end by 75")
    found = rolf.get("/api/assignments", params={"video": tracked_home.video_id, "person": "Anna"}).json()[
        "assignments"
    ]
    assert [(one["first"], one["stop"]) for one in found] == [(0, 40), (40, 75)]


def test_reopened_work_does_not_overlap_later_work(tracked_home: ToyHome, team: Team) -> None:
    rolf = team.client("Rolf")
    (one,) = assign(rolf, tracked_home.video_id, stop=40).json()["assignments"]
    done = change(rolf, one, state="done").json()
    (later,) = assign(rolf, tracked_home.video_id, first=39).json()["assignments"]
    refused = change(rolf, done, state="returned", comment="again")
    assert_refused(refused, 409, "Anna has drive.mp4 already, from frame 39")
    assert change(rolf, later, state="done").status_code == 200
    assert change(rolf, done, state="returned", comment="again").status_code == 200


def test_done_work_of_another_person_does_not_overlap(tracked_home: ToyHome, team: Team) -> None:
    rolf = team.client("Rolf")
    (one,) = assign(rolf, tracked_home.video_id, stop=40).json()["assignments"]
    assert assign(rolf, tracked_home.video_id, person="Rolf").status_code == 201
    assert_refused(change(rolf, one, person="Rolf"), 409, "Rolf has drive.mp4 already, whole")
    moved = change(rolf, one, person="Rolf", state="done").json()
    assert (moved["person"], moved["state"]) == ("Rolf", "done")


def test_a_video_is_assigned_during_its_import(tracked_home: ToyHome, team: Team) -> None:
    with tracked_home.database.write() as session:
        session.add(Video(id="1" * 64, name="new", path="/new", size=1, state="importing", frames=5, warnings=[]))
    try:
        answer = assign(team.client("Rolf"), "1" * 64, first=10, stop=60)
        assert answer.status_code == 201, answer.text
    finally:
        with tracked_home.database.write() as session:
            session.delete(session.get_one(Video, "1" * 64))


def test_all_videos_or_none(tracked_home: ToyHome, team: Team) -> None:
    rolf = team.client("Rolf")
    body = {"videos": [tracked_home.video_id, "0" * 64], "person": "Anna"}
    assert_refused(rolf.post("/api/assignments", json=body), 404, "There is no video")
    assert_refused(assign(rolf, tracked_home.video_id, "Eve"), 404, "no person 'Eve'")
    assert_refused(assign(rolf, tracked_home.video_id, "Vera"), 422, "Vera is a viewer")
    assert rolf.get("/api/assignments").json() == {"assignments": []}


def test_returned_work_comes_first_and_pages_are_notified(
    tracked_home: ToyHome, team_server: Server, team: Team
) -> None:
    rolf, anna = team.client("Rolf"), team.client("Anna")
    made_ones = [assign(rolf, tracked_home.video_id, first=f, stop=f + 5).json()["assignments"][0] for f in (0, 10, 20)]
    handed = change(anna, made_ones[2], state="in_review").json()
    change(rolf, handed, state="returned", comment="again")
    change(anna, made_ones[0], state="in_review")
    states = [one["state"] for one in anna.get("/api/assignments").json()["assignments"]]
    assert states == ["returned", "assigned", "in_review"]
    with team_server.context.database.read() as session:
        newest = team_server.context.events.newest(session)
        told = [event for event in team_server.context.events.after(session, 0, 10_000) if event.kind == "assignment"]
    assert told[-1].seq == newest
    assert told[-1].data["state"] == "in_review"
    team_server.context.people.remove("Anna")
    assert rolf.get("/api/assignments").json() == {"assignments": []}
