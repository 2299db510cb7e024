"""Following over HTTP: started, watched, replaced, dropped, abandoned; proposals that nobody accepted leave nothing
behind.
"""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import select

from app.follows import prepared_video
from app.follows.task import follow_track
from app.job_subjects import on_job_failed
from app.jobs.context import Stopped, TaskContext
from app.storage.models import Follow, Video
from tests.app.follows.follow_requests import NO_ROWS, anchor_of, edit, start_follow, stored_rows
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server

FRAMES = 75


def test_proposals_arrive_in_pieces_each_delivered_once(server: Server, run: str) -> None:
    anchor = anchor_of(server, run)
    follow = start_follow(server, run, [anchor])
    assert (follow["state"], follow["proposals"], follow["next"]) == ("queued", [], 0)
    run_jobs(server.context)
    found = server.client.get(f"/api/follows/{follow['id']}").json()
    assert found["state"] == "complete"
    frames = {row[0] for row in found["proposals"]}
    assert anchor["frame"] in frames
    assert len(frames) > 5
    assert frames <= set(range(FRAMES))
    for _, x1, y1, x2, y2, confidence, source in found["proposals"]:
        assert x1 < x2
        assert y1 < y2
        assert 0 <= confidence <= 1
        assert source in ("anchor", "detected", "matched", "predicted")
    assert {ending["direction"] for ending in found["endings"]} == {"backward", "forward"}
    again = server.client.get(f"/api/follows/{follow['id']}", params={"after": found["next"]}).json()
    assert (again["proposals"], again["next"]) == ([], found["next"])


def test_limits_and_one_direction_are_respected(server: Server, run: str) -> None:
    anchor = anchor_of(server, run)
    follow = start_follow(server, run, [anchor], only="forward", last=anchor["frame"] + 3)
    run_jobs(server.context)
    found = server.client.get(f"/api/follows/{follow['id']}").json()
    frames = {row[0] for row in found["proposals"]}
    assert min(frames) == anchor["frame"]
    assert max(frames) <= anchor["frame"] + 3


def test_accepting_is_one_edit_with_one_undo(server: Server, run: str) -> None:
    anchor = anchor_of(server, run)
    boxes = [
        {"frame": k, "box": [10.0 + k, 10, 30.0 + k, 30], "anchor": k == anchor["frame"]}
        for k in range(anchor["frame"] + 3)
    ]
    command = {"name": "follow", "frame": anchor["frame"], "key": "m1", "boxes": boxes}
    first = server.client.post(
        f"/api/runs/{run}/edits",
        headers={"If-Match": '"m1:0"'},
        json={"op_id": "follow-0001", "author": "ada", "command": command},
    )
    assert first.status_code == 200, first.text
    keys = first.json()["docs"][0]["keys"]
    assert [key["followed"] for key in keys.values()].count(False) == 1
    assert keys[str(anchor["frame"])]["followed"] is False
    undone = server.client.post(
        f"/api/runs/{run}/edits",
        json={"op_id": "follow-undo1", "author": "ada", "command": {"name": "undo", "op_id": "follow-0001"}},
    )
    assert undone.status_code == 200, undone.text
    assert undone.json()["docs"][0]["keys"] == {}


def test_a_box_beyond_the_video_is_refused(server: Server, run: str) -> None:
    command = {
        "name": "follow",
        "frame": 0,
        "key": "m1",
        "boxes": [{"frame": FRAMES, "box": [0, 0, 9, 9], "anchor": True}],
    }
    answer = server.client.post(
        f"/api/runs/{run}/edits",
        headers={"If-Match": '"m1:0"'},
        json={"op_id": "follow-0002", "author": "ada", "command": command},
    )
    assert (answer.status_code, answer.json()["error"]["code"]) == (422, "no_such_frame")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"anchors": [{"frame": FRAMES, "box": [0, 0, 9, 9]}]}, "frames 0 to 74"),
        ({"anchors": [{"frame": 3, "box": [0, 0, 9, 9]}, {"frame": 3, "box": [1, 1, 9, 9]}]}, "one frame"),
        ({"anchors": [{"frame": 3, "box": [0, 0, 9, 9]}], "first": 5}, "5 to 74"),
        ({"anchors": [{"frame": 3, "box": [0, 0, 9, 9]}], "only": "between"}, "second frame"),
        ({"anchors": [{"frame": 3, "box": [9, 0, 0, 9]}]}, "x1 < x2"),
        ({"anchors": []}, "at least 1"),
    ],
)
def test_invalid_requests_are_refused_before_any_work(
    server: Server, run: str, change: dict[str, Any], words: str
) -> None:
    answer = server.client.post(f"/api/runs/{run}/follows", json={"key": "m1", **change})
    assert answer.status_code == 422
    assert words in answer.json()["error"]["message"]
    assert stored_rows(server) == NO_ROWS


def test_a_newer_request_of_the_same_person_replaces_the_older_one(server: Server, run: str) -> None:
    anchor = anchor_of(server, run)
    with ThreadPoolExecutor(10) as pool:  # ten at once
        list(pool.map(lambda _: start_follow(server, run, [anchor]), range(10)))
    last = start_follow(server, run, [anchor])
    other = start_follow(server, run, [anchor], author="bob")
    assert stored_rows(server) == {"follows": 2, "follow_pieces": 0, "jobs": 2, "events": 0}
    found = server.client.get(f"/api/runs/{run}/follows").json()["found"]
    assert found["id"] == last["id"]
    assert server.client.get(f"/api/runs/{run}/follows", params={"author": "bob"}).json()["found"]["id"] == other["id"]


@pytest.mark.parametrize("change", [{"type": "hide", "id": 14}, {"type": "merge", "id": 14, "into": 13}])
def test_proposals_are_accepted_after_their_label_was_removed(server: Server, run: str, change: dict[str, Any]) -> None:
    anchor, key = anchor_of(server, run), "hdrawn01"
    drawn = {"name": "create_track", "frame": anchor["frame"], "key": key, "box": anchor["box"], "class_id": 14}
    edit(server, run, "follow-0003", drawn, 0)
    follow = start_follow(server, run, [anchor], key=key)
    changed = server.client.post("/api/label-sets/gtsrb-43/changes", json={"author": "bob", "change": change})
    assert changed.status_code == 200, changed.text
    run_jobs(server.context, "follow")
    found = server.client.get(f"/api/follows/{follow['id']}").json()
    assert found["state"] == "complete"
    boxes = [{"frame": row[0], "box": row[1:5], "anchor": row[6] == "anchor"} for row in sorted(found["proposals"])]
    (before,) = server.client.get(f"/api/runs/{run}/annotation").json()["docs"]
    taken = {"name": "follow", "frame": anchor["frame"], "key": key, "boxes": boxes}
    edit(server, run, "follow-0004", taken, before["revision"])
    (after,) = server.client.get(f"/api/runs/{run}/annotation").json()["docs"]
    assert len(after["keys"]) > 5
    assert after["class_id"] == before["class_id"]


def test_dropped_proposals_leave_no_trace(server: Server, run: str) -> None:
    follow = start_follow(server, run, [anchor_of(server, run)])
    run_jobs(server.context)
    for _ in range(2):
        assert server.client.delete(f"/api/follows/{follow['id']}").status_code == 204
    assert stored_rows(server) == NO_ROWS
    assert server.client.get(f"/api/runs/{run}/annotation").json()["docs"] == []


def test_a_follow_dropped_while_running_leaves_no_trace(server: Server, run: str) -> None:
    context = server.context
    follow = start_follow(server, run, [anchor_of(server, run)])
    with context.database.read() as session:
        (waiting,) = context.jobs.waiting_ids(session)
    with context.database.write() as session:
        job = context.jobs.claim(session, waiting)
    assert job is not None
    server.client.delete(f"/api/follows/{follow['id']}")
    task = TaskContext(context.settings, context.database, context.events, context.jobs, job, lambda: False)
    with pytest.raises(Stopped):
        follow_track(task)
    with context.database.write() as session:
        context.jobs.finish(session, job.id, job.token, "cancelled")
        on_job_failed(Follow, session, context.events, job, "cancelled", None)
    assert stored_rows(server) == NO_ROWS


@pytest.mark.parametrize("what", ["gone", "replaced"])
def test_a_missing_or_replaced_file_is_reported(server: Server, run: str, what: str, home: Any) -> None:
    follow = start_follow(server, run, [anchor_of(server, run)])
    with server.context.database.write() as session:
        video = session.scalars(select(Video)).one()
        other = Path(str(server.settings.home)) / "other.mp4"
        if what == "replaced":
            other.write_bytes(home.video.read_bytes() + b"\0")
        video.path = str(other)
    run_jobs(server.context)
    found = server.client.get(f"/api/follows/{follow['id']}").json()
    assert found["state"] == "failed"
    assert ("is missing" if what == "gone" else "has changed") in found["error"]


@pytest.mark.parametrize("short", [5000, 10], ids=["here", "in a sandbox"])
def test_a_sign_is_followed_on_a_video_without_a_run(
    server: Server, run: str, short: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.exchange.sandboxed_imports.MAX_FRAMES_IN_SERVER", short)
    anchor = anchor_of(server, run)
    with server.context.database.read() as session:
        video = session.scalars(select(Video.id)).one()
    made = server.client.post(f"/api/videos/{video}/runs/by-hand", json={})
    assert made.status_code == 201, made.text
    by_hand = made.json()
    assert (by_hand["state"], by_hand["tracks"], by_hand["frames_done"]) == ("complete", 0, FRAMES)
    assert server.client.get(f"/api/runs/{by_hand['id']}/tracks").json()["id"] == []
    follow = start_follow(server, by_hand["id"], [anchor], key="hdrawn01")
    run_jobs(server.context, "follow")
    found = server.client.get(f"/api/follows/{follow['id']}").json()
    assert found["state"] == "complete"
    assert len({row[0] for row in found["proposals"]}) > 5
    command = {
        "name": "create_track",
        "frame": anchor["frame"],
        "key": "hdrawn01",
        "box": anchor["box"],
        "class_id": 14,
    }
    operation = {"op_id": "by-hand-001", "author": "ada", "command": command}
    edit = server.client.post(f"/api/runs/{by_hand['id']}/edits", headers={"If-Match": '"hdrawn01:0"'}, json=operation)
    assert edit.status_code == 200, edit.text


def test_a_waiting_page_receives_proposals_at_once(server: Server, run: str) -> None:
    follow = start_follow(server, run, [anchor_of(server, run)])
    began = datetime.now(UTC)
    server.client.get(f"/api/follows/{follow['id']}", params={"wait": 0.2})
    assert datetime.now(UTC) - began >= timedelta(seconds=0.2)
    run_jobs(server.context)
    answer = server.client.get(f"/api/follows/{follow['id']}", params={"wait": 10}).json()
    assert answer["state"] == "complete"


def test_preparation_changes_only_the_time_of_proposals(
    server: Server, run: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    anchor = anchor_of(server, run)
    opened: list[object] = []
    open_anew = prepared_video._open

    def counted(*args: Any) -> Any:
        opened.append(args)
        return open_anew(*args)

    monkeypatch.setattr(prepared_video, "_open", counted)

    def proposals() -> list[Any]:
        follow = start_follow(server, run, [anchor])
        run_jobs(server.context)
        found: list[Any] = server.client.get(f"/api/follows/{follow['id']}").json()["proposals"]
        return found

    cold = proposals()
    for frame in (anchor["frame"] - 2, anchor["frame"], FRAMES + 5):
        prepared_video.prepare_video(server.settings, server.context.database, run, frame)
    assert len(opened) == 2
    assert proposals() == cold
    assert len(opened) == 2
    assert prepared_video._prepared == []


def test_a_file_replaced_after_preparation_is_reported(server: Server, run: str, home: Any) -> None:
    anchor = anchor_of(server, run)
    with server.context.database.write() as session:
        video = session.scalars(select(Video)).one()
        other = Path(str(server.settings.home)) / "other.mp4"
        other.write_bytes(home.video.read_bytes())
        video.path = str(other)
    prepared_video.prepare_video(server.settings, server.context.database, run, anchor["frame"])
    assert len(prepared_video._prepared) == 1
    other.write_bytes(home.video.read_bytes() + b"\0")
    follow = start_follow(server, run, [anchor])
    run_jobs(server.context)
    found = server.client.get(f"/api/follows/{follow['id']}").json()
    assert (found["state"], found["proposals"]) == ("failed", [])
    assert "has changed" in found["error"]
    prepared_video.prepare_video(server.settings, server.context.database, run, anchor["frame"])
    assert prepared_video._prepared == []


def test_the_standby_worker_is_notified(server: Server, run: str) -> None:
    heard: list[object] = []
    server.context.jobs.notify_standby = heard.append
    answer = server.client.post(f"/api/runs/{run}/follows/expected", json={"frame": 7})
    assert (answer.status_code, heard) == (204, [("follow", {"run_id": run, "frame": 7})])
    start_follow(server, run, [anchor_of(server, run)])
    assert heard[1:] == [None]
    assert server.client.post(f"/api/runs/{'0' * 32}/follows/expected", json={"frame": 7}).status_code == 404
    assert len(heard) == 2


def test_a_waiting_page_reads_a_new_note_at_once(server: Server, run: str, monkeypatch: pytest.MonkeyPatch) -> None:
    follows = server.context.follows
    follow = follows.view(start_follow(server, run, [anchor_of(server, run)])["id"])
    views = iter([follow, follow, follow.model_copy(update={"note": "compiling"})])
    monkeypatch.setattr(follows, "view", lambda *_: next(views))
    assert asyncio.run(follows.wait(follow.id, 0, 600.0)).note == "compiling"
