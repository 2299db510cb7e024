"""Second opinions over HTTP on both kinds of database: blind, fair, with consistent figures."""

from __future__ import annotations

import uuid

import pytest
from sqlalchemy import delete, select

from app.people.agreement_statistics import mean_interval, share_interval
from app.people.box_agreement import drawn_twice
from app.storage.models import SecondOpinion
from tests.app.people.team import Team
from tests.app.people.test_authors import keys_of, run, send
from tests.app.toy_server import Server

__all__ = ["run"]


@pytest.fixture(autouse=True)
def no_second_opinions(team_server: Server) -> None:
    """Without any assignment."""
    with team_server.context.database.write() as session:
        session.execute(delete(SecondOpinion))


def test_a_second_person_does_not_see_the_first_answer(team_server: Server, team: Team, run: str) -> None:
    anna, rolf = team.client("Anna"), team.client("Rolf")
    first, second = keys_of(anna, run)[:2]
    for key, label in ((first, 14), (second, 13)):
        send(anna, run, "Anna", key=key, name="relabel_track", class_id=label)
        send(anna, run, "Anna", 1, key=key, name="set_review", review="accepted")

    assert rolf.post("/api/second-opinions", json={"person": "Anna", "share": 1}).json()["given"] == 0, "her own"
    assert rolf.post("/api/second-opinions", json={"person": "Rolf", "share": 1}).json() == {
        "given": 2,
        "accepted": 2,
        "unread": 0,
    }
    again = rolf.post("/api/second-opinions", json={"person": "Rolf", "share": 1}).json()
    assert again == {"given": 0, "accepted": 2, "unread": 0}, "every track once"

    answers = {first: 14, second: None}
    seen = []
    for left in (2, 1):
        found = rolf.get("/api/second-opinions/next").json()
        assert found["left"] == left
        look = found["look"]
        assert set(look) == {"id", "run_id", "video_name", "frame", "box", "labels"}, "nothing of the first answer"
        assert {"id": 14, "name": "stop"} in look["labels"]
        with team_server.context.database.read() as session:
            key = session.get_one(SecondOpinion, look["id"]).key
        seen.append(key)
        refused = anna.post(f"/api/second-opinions/{look['id']}/answer", json={"label": 14})
        assert (refused.status_code, refused.json()["error"]["code"]) == (403, "not_yours")
        assert rolf.post(f"/api/second-opinions/{look['id']}/answer", json={"label": 9999}).status_code == 422
        assert rolf.post(f"/api/second-opinions/{look['id']}/answer", json={"label": answers[key]}).status_code == 204
        twice = rolf.post(f"/api/second-opinions/{look['id']}/answer", json={"label": 14})
        assert (twice.status_code, twice.json()["error"]["code"]) == (409, "answered")
    assert sorted(seen) == sorted([first, second])
    assert rolf.get("/api/second-opinions/next").json() == {"look": None, "left": 0}

    report = rolf.get("/api/second-opinions").json()
    assert (report["open"], report["whole"]["looked"], report["whole"]["agreed"]) == (0, 2, 1)
    assert {one["name"]: one["agreed"] for one in report["labels"]} == {"stop": 1, "give way": 0}
    assert [(one["name"], one["looked"], one["agreed"]) for one in report["first"]] == [("Anna", 2, 1)]
    assert [(one["name"], one["looked"], one["agreed"]) for one in report["second"]] == [("Rolf", 2, 1)]
    assert report["whole"]["low"] < 0.5 < report["whole"]["high"]
    (dispute,) = report["disputes"]
    assert (dispute["key"], dispute["first_answer"], dispute["second_answer"]) == (second, "give way", "no sign")

    send(rolf, run, "Rolf", 2, key=second, name="set_review", review="rejected")
    report = rolf.get("/api/second-opinions").json()
    assert (report["disputed"], report["whole"]["agreed"]) == (0, 1), "settled, but they did not agree"


def test_second_opinions_need_permission(team: Team, run: str) -> None:
    anna, rolf, vera = team.client("Anna"), team.client("Rolf"), team.client("Vera")
    assert anna.post("/api/second-opinions", json={"person": "Anna", "share": 1}).status_code == 403
    assert anna.get("/api/second-opinions").status_code == 403
    assert vera.get("/api/second-opinions/next").status_code == 403
    assert rolf.post("/api/second-opinions", json={"person": "Vera", "share": 1}).status_code == 422
    assert rolf.post("/api/second-opinions", json={"person": "Eve", "share": 1}).status_code == 404
    assert rolf.post("/api/second-opinions", json={"person": "Anna", "share": 0}).status_code == 422
    assert rolf.post("/api/second-opinions/999999/answer", json={"label": 1}).status_code == 404


def test_work_of_a_removed_person_is_given_to_another(team_server: Server, team: Team, run: str) -> None:
    anna, rolf = team.client("Anna"), team.client("Rolf")
    key = keys_of(anna, run)[0]
    send(anna, run, "Anna", key=key, name="set_review", review="accepted")
    team_server.context.people.add("Zoe", "annotator")
    assert rolf.post("/api/second-opinions", json={"person": "Zoe", "share": 1}).json()["given"] == 1
    team_server.context.people.remove("Zoe")
    assert rolf.post("/api/second-opinions", json={"person": "Rolf", "share": 1}).json()["given"] == 1
    with team_server.context.database.read() as session:
        assert session.scalars(select(SecondOpinion.second)).all() == ["Rolf"]


def test_an_answer_does_not_count_for_a_later_second_opinion(team_server: Server, team: Team, run: str) -> None:
    anna, rolf = team.client("Anna"), team.client("Rolf")
    send(anna, run, "Anna", key=keys_of(anna, run)[0], name="set_review", review="accepted")
    assert rolf.post("/api/second-opinions", json={"person": "Rolf", "share": 1}).json()["given"] == 1
    look = rolf.get("/api/second-opinions/next").json()["look"]
    with team_server.context.database.write() as session:
        session.execute(delete(SecondOpinion))  # as if its run was removed
    assert rolf.post("/api/second-opinions", json={"person": "Rolf", "share": 1}).json()["given"] == 1
    refused = rolf.post(f"/api/second-opinions/{look['id']}/answer", json={"label": 14})
    assert refused.status_code == 404, "the answer was to another sign"


def test_boxes_drawn_by_two_people(team: Team, run: str) -> None:
    anna, rolf = team.client("Anna"), team.client("Rolf")
    first, second = keys_of(anna, run)[:2]
    send(anna, run, "Anna", key=first, name="relabel_track", class_id=14)
    send(anna, run, "Anna", 1, key=first, name="set_box", box=[0, 0, 9, 9])
    send(anna, run, "Anna", 2, key=first, name="set_box", box=[0, 0, 10, 10])  # the last one counts
    assert rolf.get("/api/second-opinions").json()["boxes"]["whole"]["tracks"] == 0
    send(rolf, run, "Rolf", 3, key=first, name="set_box", box=[0, 0, 10, 5])
    send(anna, run, "Anna", key=second, name="relabel_track", class_id=13)
    send(anna, run, "Anna", 1, key=second, name="set_box", box=[0, 0, 10, 10])
    send(rolf, run, "Rolf", 2, key=second, name="set_box", box=[20, 20, 30, 30])
    boxes = rolf.get("/api/second-opinions").json()["boxes"]
    assert (boxes["whole"]["tracks"], boxes["whole"]["frames"], boxes["whole"]["iou"]) == (2, 2, 0.25)
    assert (boxes["whole"]["low"], boxes["whole"]["high"]) == (0, 1)
    assert {one["name"]: one["iou"] for one in boxes["labels"]}["stop"] == 0.5
    assert [(one["name"], one["tracks"]) for one in boxes["first"]] == [("Anna", 2)]
    assert [(one["name"], one["frames"]) for one in boxes["second"]] == [("Rolf", 2)]
    newest = rolf.get(f"/api/runs/{run}/annotation", params={"author": "Rolf"}).json()["undo"]["op_id"]
    back = {"op_id": uuid.uuid4().hex, "author": "Rolf", "command": {"name": "undo", "op_id": newest}}
    assert rolf.post(f"/api/runs/{run}/edits", json=back).status_code == 200
    whole = rolf.get("/api/second-opinions").json()["boxes"]["whole"]
    assert (whole["tracks"], whole["iou"]) == (1, 0.5), "what was undone counts for nothing"


def test_boxes_that_two_people_drew_are_compared() -> None:
    box, other = (0.0, 0.0, 10.0, 10.0), (5.0, 0.0, 15.0, 10.0)
    rows = [("a", "r", "m1", 3, box), ("b", "r", "m1", 3, other), ("a", "r", "m1", 3, box), ("b", "r", "m1", 4, box)]
    found = drawn_twice(rows)
    assert [(one.first, one.second, one.iou) for one in found] == [
        ("a", "b", pytest.approx(1 / 3)),
        ("b", "a", pytest.approx(1 / 3)),
    ]
    assert drawn_twice([]) == []
    mean, low, high = mean_interval([0.5, 0.7, 0.9])
    assert (mean, low, high) == (
        pytest.approx(0.7),
        pytest.approx(0.2032, abs=1e-4),
        1.0,
    )  # equals scipy.stats.t.interval
    assert mean_interval([0.9]) == (0.9, 0.0, 1.0)


def test_shares_have_wilson_intervals() -> None:
    assert share_interval(0, 0) == (0, 1)
    assert share_interval(5, 10) == pytest.approx((0.2366, 0.7634), abs=1e-4)  # Wilson's interval, equal to statsmodels
    assert share_interval(10, 10) == pytest.approx((0.7225, 1.0), abs=1e-4)
    assert share_interval(0, 10) == pytest.approx((0.0, 0.2775), abs=1e-4)
