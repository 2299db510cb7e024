"""Actions on found tracks: one operation per run, one undo, and unchanged tracks are named."""

from __future__ import annotations

import csv
from pathlib import Path

from app.exchange.export import ExportRequest, export_sources
from app.exchange.run_sources import run_source
from tests.app.search.conftest import Library


def test_many_tracks_are_judged_in_one_operation_with_one_undo(library: Library) -> None:
    tracks = library.search()["tracks"]
    done = library.act({"type": "judge", "review": "accepted"}, tracks, author="ann")
    assert (done["changed"], done["stayed"], len(done["operations"])) == (len(tracks), 0, 1)
    assert {track["state"] for track in done["tracks"]} == {"accepted"}
    assert library.search(state="accepted", author="ann")["total"] == len(tracks)
    (row,) = library.page().log()
    assert (row["name"], sorted(row["keys"])) == ("edit_tracks", sorted(track["key"] for track in tracks))
    undone = library.undo(done, author="ann")
    assert (undone["changed"], undone["stayed"]) == (len(tracks), 0)
    assert library.search(state="open")["total"] == len(tracks)


def test_the_same_action_sent_twice_is_carried_out_once(library: Library) -> None:
    tracks = library.search()["tracks"]
    action = {"type": "judge", "review": "rejected"}
    first = library.act(action, tracks, action_id="0" * 8 + library.run[:8])
    second = library.act(action, tracks, action_id="0" * 8 + library.run[:8])
    assert (first["changed"], first["operations"]) == (second["changed"], second["operations"])
    assert len(library.page().log()) == 1


def test_a_track_changed_since_is_kept_and_named(library: Library) -> None:
    tracks = library.search()["tracks"]
    key = tracks[0]["key"]
    bob = library.page()
    bob.author = "bob"
    assert bob.send({"name": "set_review", "frame": 5, "key": key, "review": "needs_work"}, f'"{key}:0"').is_success
    done = library.act({"type": "judge", "review": "accepted"}, tracks, author="ann")
    assert (done["changed"], done["stayed"]) == (len(tracks) - 1, 1)
    assert done["sentences"] == [f"drive.mp4, track {key[1:]}: it was changed meanwhile by bob."]
    assert bob.docs()[key]["review"] == "needs_work"


def test_an_undo_that_would_lose_edits_of_others_is_refused(library: Library) -> None:
    tracks = library.search()["tracks"]
    done = library.act({"type": "judge", "review": "accepted"}, tracks, author="ann")
    key = tracks[0]["key"]
    bob = library.page()
    bob.author = "bob"
    assert bob.send({"name": "set_review", "frame": 5, "key": key, "review": "rejected"}, f'"{key}:1"').is_success
    undone = library.undo(done, author="ann")
    assert (undone["changed"], undone["stayed"]) == (0, 1)
    assert undone["sentences"][0].startswith("drive.mp4: ")


def test_a_label_is_given_by_name(library: Library) -> None:
    tracks = library.search()["tracks"][:1]
    done = library.act({"type": "relabel", "label": "give way"}, tracks)
    assert done["tracks"][0]["label"]["name"] == "give way"
    assert library.keys(label="give way", author="ada") == [tracks[0]["key"]]
    again = library.act({"type": "relabel", "label": "give way"}, done["tracks"])
    assert (again["changed"], again["stayed"], again["operations"]) == (0, 0, [])  # it already has that label


def test_an_unknown_label_is_refused(library: Library) -> None:
    track = library.search()["tracks"][0]
    wanted = [{name: track[name] for name in ("run", "key", "revision")}]
    body = {"action_id": "x" * 12, "action": {"type": "relabel", "label": "unicorn"}, "tracks": wanted}
    answer = library.server.client.post("/api/search/actions", json=body)
    assert answer.status_code == 422
    assert "has no label 'unicorn'" in answer.json()["error"]["message"]


def test_an_ignored_region_is_found_as_such(library: Library) -> None:
    track = library.search()["tracks"][0]
    done = library.act({"type": "ignore", "value": True}, [track])
    assert [each["state"] for each in done["tracks"]] == ["ignored"]
    assert library.keys(state="ignored") == [track["key"]]
    library.act({"type": "ignore", "value": False}, done["tracks"])
    assert library.keys(state="ignored") == []


def test_a_removed_run_does_not_block_the_others(library: Library) -> None:
    tracks = library.search()["tracks"]
    lost = {"run": "0" * 32, "key": "m1", "revision": 0}
    done = library.act({"type": "judge", "review": "accepted"}, [lost, *tracks])
    assert (done["changed"], done["stayed"]) == (len(tracks), 1)
    assert "There is no run" in done["sentences"][0]


def test_an_export_can_be_limited_to_chosen_tracks(library: Library, tmp_path: Path) -> None:
    ann, key, drawn = library.page(), library.keys()[0], "h" + "b2" * 6
    assert ann.send({"name": "create_track", "frame": 3, "key": drawn, "box": [9, 9, 40, 40], "class_id": 1}).is_success
    with library.home.database.read() as session:
        source = run_source(session, library.home.settings, library.run)
    states = ["open", "edited", "accepted", "rejected", "needs_work"]
    asked = {"runs": [library.run], "format": "tracks-csv", "states": states, "not_in_set": "class"}
    rows = {}
    for name, tracks in {"all": None, "one": {library.run: [drawn]}, "both": {library.run: [key, drawn]}}.items():
        request = ExportRequest.model_validate({**asked, "tracks": tracks})
        export_sources(request, [source], tmp_path / name, zipped=False)
        (file,) = (path for path in (tmp_path / name).rglob("*.csv") if "track" in path.read_text().split("\n")[0])
        rows[name] = list(csv.DictReader(file.read_text().splitlines()))
    assert len(rows["one"]) == 1
    assert len(rows["one"]) < len(rows["both"]) < len(rows["all"])
