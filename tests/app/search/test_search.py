"""Queries over HTTP: filters, order, pages, and updates after edits."""

from __future__ import annotations

import base64
import json
import shutil
from pathlib import Path

import pytest

from app.files.shared import ensure_local
from app.settings import Settings
from tests.app.edits.edit_client import EditClient
from tests.app.search.conftest import Library


def test_every_track_of_the_newest_run_is_found_once(library: Library) -> None:
    found = library.search()
    tracks = library.server.client.get(f"/api/runs/{library.run}/tracks").json()
    assert {track["run"] for track in found["tracks"]} == {library.run}
    assert sorted(track["key"] for track in found["tracks"]) == sorted(f"m{number}" for number in tracks["id"])
    assert (found["total"], found["more"], found["next"], found["unread"]) == (len(tracks["id"]), False, None, 0)
    of_track = {f"m{number}": value for number, value in zip(tracks["id"], tracks["uncertainty"], strict=True)}
    assert [track["uncertainty"] for track in found["tracks"]] == sorted(of_track.values(), reverse=True)
    assert all(track["uncertainty"] == of_track[track["key"]] for track in found["tracks"])


def test_a_verdict_a_note_and_a_label_are_found_at_once(library: Library) -> None:
    ann, key = library.page(), library.keys()[0]
    assert ann.send({"name": "set_review", "frame": 5, "key": key, "review": "accepted"}, f'"{key}:0"').is_success
    assert library.keys(state="accepted") == [key]
    assert key not in library.keys(state="open")
    note = {"name": "add_note", "frame": 5, "key": key, "note_id": "n1", "text": "Halb verdeckt: 100 % SCHMUTZ"}
    assert ann.send(note, f'"{key}:1"').is_success
    assert library.keys(text="schmutz verdeckt") == [key]
    assert library.keys(text="100 %") == [key]
    assert library.keys(text="100_%") == []
    assert ann.send({"name": "relabel_track", "frame": 5, "key": key, "class_id": 14}, f'"{key}:2"').is_success
    (found,) = library.search(label="stop", author="ann")["tracks"]
    assert (found["key"], found["label"], found["revision"]) == (key, {"set": "gtsrb-43", "id": 14, "name": "stop"}, 3)
    assert library.keys(label=["stop"], author="bob") == []
    assert library.keys(label="none", author="ann") == []


def test_deleted_tracks_are_not_found_until_undo(library: Library) -> None:
    ann, keys = library.page(), library.keys()
    done = ann.send({"name": "delete_track", "frame": 5, "key": keys[0]}, f'"{keys[0]}:0"')
    assert library.keys() == keys[1:]
    assert ann.send({"name": "undo", "op_id": done.json()["op_id"]}).is_success
    assert sorted(library.keys()) == sorted(keys)


def test_a_drawn_track_is_found_by_its_largest_box(library: Library) -> None:
    ann, key = library.page(), "h" + "a1" * 6
    assert ann.send({"name": "create_track", "frame": 3, "key": key, "box": [10, 10, 40, 60], "class_id": 1}).is_success
    assert ann.send({"name": "set_box", "frame": 9, "key": key, "box": [10, 10, 250, 60]}, f'"{key}:1"').is_success
    (found,) = library.search(size_min=200)["tracks"]
    assert (found["key"], found["frame"], found["box"], found["size"]) == (key, 9, [10, 10, 250, 60], 240)
    assert (found["first"], found["last"], found["uncertainty"], found["author"]) == (3, 9, 0, "ann")
    assert key not in library.keys(size_max=200)


def test_attributes_are_found_by_name_and_by_value(library: Library) -> None:
    ann, key = library.page(), library.keys()[0]
    added = {"type": "add", "name": f"wet {library.run[:6]}", "attributes": [{"name": "ground", "kind": "text"}]}
    label = library.server.client.post("/api/label-sets/gtsrb-43/changes", json={"change": added}).json()["label"]["id"]
    assert ann.send({"name": "relabel_track", "frame": 5, "key": key, "class_id": label}, f'"{key}:0"').is_success
    said = {"name": "attribute", "frame": 5, "key": key, "attribute": "ground", "value": "Sehr nass"}
    assert ann.send(said, f'"{key}:1"').is_success
    assert library.keys(attribute="ground") == library.keys(attribute="ground = sehr NASS") == [key]
    assert library.keys(attribute=["ground", "ground=dry"]) == []


def test_a_merged_label_is_found_by_its_successor(library: Library) -> None:
    ann, key, set_ = library.page(), library.keys()[0], "/api/label-sets/gtsrb-43/changes"
    made = []
    for name in (f"old {library.run[:6]}", f"new {library.run[:6]}"):
        answer = library.server.client.post(set_, json={"change": {"type": "add", "name": name}})
        made.append(answer.json()["label"])
    old, new = made
    assert ann.send({"name": "relabel_track", "frame": 5, "key": key, "class_id": old["id"]}, f'"{key}:0"').is_success
    assert library.keys(label=old["key"]) == [key]
    assert library.keys(label=new["key"]) == []
    merge = {"type": "merge", "id": old["id"], "into": new["id"]}
    assert library.server.client.post(set_, json={"change": merge}).is_success
    (found,) = library.search(label=new["key"])["tracks"]
    assert found["label"]["name"] == new["name"]


def test_pages_follow_each_other_in_both_orders(library: Library) -> None:
    whole = library.keys()
    assert len(whole) >= 2
    for order, expected in (("desc", whole), ("asc", whole[::-1])):
        page = library.search(limit=1, order=order)
        found = [track["key"] for track in page["tracks"]]
        while page["next"] is not None:
            page = library.search(limit=1, order=order, cursor=page["next"])
            found += [track["key"] for track in page["tracks"]]
        assert found == expected
    assert "cursor" in library.refused(sort="size", cursor=library.search(limit=1)["next"])
    no_text = base64.b64encode(json.dumps(["uncertainty", "desc", 0.5, "\ud800", "m1"]).encode()).decode()
    for cursor in ("bm9uc2Vuc2U=", no_text):
        assert "cursor" in library.refused(cursor=cursor)


def test_an_older_run_is_found_on_request(library: Library) -> None:
    assert {track["run"] for track in library.search(runs="current")["tracks"]} == {library.run}
    assert library.home.run_id in {track["run"] for track in library.search(runs="all", limit=500)["tracks"]}


def test_a_removed_run_is_not_found(library: Library) -> None:
    assert library.search()["total"] > 0
    library.remove_run()
    found = library.search(runs="all", limit=500)
    assert library.run not in {track["run"] for track in found["tracks"]}
    assert library.search()["total"] > 0  # the previous run represents the video again


def test_only_a_new_run_is_read(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither the other runs of the video again, nor one of them to compare with."""
    home = library.home
    assert library.search(runs="all")["unread"] == 0
    new = home.add_run()
    shutil.copytree(home.folder, home.settings.home / "runs" / new)
    fetched: set[str] = set()

    def record(settings: Settings, place: str | None, name: str) -> Path:
        fetched.add(name)
        return ensure_local(settings, place, name)

    monkeypatch.setattr("app.evidence.service.ensure_local", record)
    with home.database.write() as session:
        home.events.publish(session, "run", new, {"state": "complete"})
    found = library.search(runs="all", limit=500)["tracks"]
    assert len([track for track in found if track["run"] == new]) >= 2
    assert fetched == {f"runs/{new}"}
    assert library.server.client.delete(f"/api/runs/{new}").is_success


def test_an_edit_after_the_removal_of_an_edited_run_is_found(library: Library) -> None:
    """On SQLite it gets the number of an edit that was removed."""
    key = library.keys()[0]
    judge = {"name": "set_review", "frame": 5, "key": key, "review": "accepted"}
    assert library.page().send(judge, f'"{key}:0"').is_success
    assert library.keys(state="accepted") == [key]
    library.remove_run()
    (revision,) = {track["revision"] for track in library.search()["tracks"] if track["key"] == key}
    assert EditClient(library.server, library.home.run_id).send(judge, f'"{key}:{revision}"').is_success
    assert library.keys(state="accepted") == [key]


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        ({"label": "no such sign"}, "or number 'no such sign'. The page Labels and 'tsr labels list' list the labels."),
        ({"label": "peed"}, "Is it 'speed limit 20 km/h', 'speed limit 30 km/h', 'speed limit 50 km/h'?"),
        ({"label": ["stop", "speed limit 6"]}, "alias or number 'speed limit 6'. Is it 'speed limit 60 km/h'"),
        ({"since": "yesterday"}, "Expected a day such as 2026-11-01"),
        ({"size_min": 9, "size_max": 3}, "The smallest size, 9, is above the largest, 3."),
        ({"uncertainty_min": 2}, "less than or equal to 1"),
        ({"state": "good"}, "'open'"),
        ({"colour": "red"}, "colour"),
    ],
)
def test_invalid_queries_are_refused(library: Library, asked: dict[str, object], sentence: str) -> None:
    library.search()
    assert sentence in library.refused(**asked)


def test_filter_by_day_of_the_last_edit(library: Library) -> None:
    ann, key = library.page(), library.keys()[0]
    assert ann.send({"name": "set_review", "frame": 5, "key": key, "review": "needs_work"}, f'"{key}:0"').is_success
    (found,) = library.search(since="2020-01-01", sort="edited")["tracks"]
    day = found["edited"][:10]
    assert found["key"] == key
    assert library.keys(since=day, until=day) == [key]
    assert library.keys(until="2020-01-01") == library.keys(since="2100-01-01") == []
    assert library.keys(since="0001-01-01", until="9999-12-31") == [key]
    assert library.search(sort="edited")["tracks"][0]["key"] == key


def test_a_number_finds_signs_with_that_number(library: Library) -> None:
    library.search()
    meant = library.search(label="60")["labels"]
    assert [label["name"] for label in meant] == ["speed limit 60 km/h"]
    assert library.search(label="#14")["labels"][0]["name"] == "stop"


def test_words_of_a_name_find_all_labels_with_them(library: Library) -> None:
    ann, keys = library.page(), library.keys()
    for key, label in zip(keys, (27, 14), strict=False):
        relabel = {"name": "relabel_track", "frame": 5, "key": key, "class_id": label}
        assert ann.send(relabel, f'"{key}:0"').is_success
    found = library.search(label="pedestrian")
    assert {track["key"] for track in found["tracks"]} >= {keys[0]}
    assert {track["label"]["name"] for track in found["tracks"]} <= {label["name"] for label in found["labels"]}
    assert found["labels"] == [{"set": "gtsrb-43", "id": 27, "name": "pedestrians"}]
    limits = library.search(label=["end km", "stop", "80"])["labels"]
    assert [label["name"] for label in limits] == ["end of speed limit 80 km/h", "stop", "speed limit 80 km/h"]


def test_a_whole_name_means_its_label_alone(library: Library) -> None:
    set_ = "/api/label-sets/gtsrb-43/changes"
    for name in (f"halt {library.run[:6]}", f"halt {library.run[:6]} ahead"):
        assert library.server.client.post(set_, json={"change": {"type": "add", "name": name}}).is_success
    whole = library.search(label=f"halt {library.run[:6]}")["labels"]
    part = library.search(label=f"{library.run[:6]} hal")["labels"]
    assert ([label["name"] for label in whole], len(part)) == ([f"halt {library.run[:6]}"], 2)


def test_filter_by_tags_of_videos(library: Library) -> None:
    client, video = library.server.client, library.home.video_id
    body = {"videos": [video], "add": ["  night  drive", "rain"]}
    assert client.post("/api/videos/tags", json=body).json() == {"changed": 1}
    assert client.post("/api/videos/tags", json=body).json() == {"changed": 0}
    assert client.get(f"/api/videos/{video}").json()["tags"] == ["night drive", "rain"]
    assert library.search(tag="night drive")["total"] == library.search()["total"] > 0
    assert library.search(tag="snow")["total"] == 0
    assert library.search(tag=["snow", "rain"])["tracks"][0]["tags"] == ["night drive", "rain"]
    assert client.post("/api/videos/tags", json={"videos": [video], "remove": ["rain", "night drive"]}).is_success
    assert client.get(f"/api/videos/{video}").json()["tags"] == []
    missing = client.post("/api/videos/tags", json={"videos": [video, "0" * 64], "add": ["half"]})
    assert (missing.status_code, client.get(f"/api/videos/{video}").json()["tags"]) == (404, [])


def test_a_video_is_found_by_words_of_its_name(library: Library) -> None:
    total = library.search()["total"]
    assert library.search(video="DRIVE mp4")["total"] == library.search(video=library.home.video_id)["total"] == total
    assert library.search(video="other")["total"] == 0


def test_a_crop_shows_the_area_of_the_box(library: Library) -> None:
    found = library.search()["tracks"][0]
    request = {"run": found["run"], "frame": found["frame"], "box": ",".join(map(str, found["box"])), "size": 64}
    crop = library.server.client.get("/api/search/crop", params=request)
    assert (crop.status_code, crop.headers["content-type"], crop.content[:4]) == (200, "image/png", b"\x89PNG")
    assert "immutable" in crop.headers["cache-control"]
    again = library.server.client.get(
        "/api/search/crop", params=request, headers={"If-None-Match": crop.headers["etag"]}
    )
    assert again.status_code == 304
    for box, status in (("9000,9000,9010,9010", 404), ("1,2,3", 422), ("5,5,4,9", 422), ("nan,0,1,1", 422)):
        assert library.server.client.get("/api/search/crop", params={**request, "box": box}).status_code == status
