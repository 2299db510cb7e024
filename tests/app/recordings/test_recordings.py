"""Recordings of a run with corrections and ground truth, from request to file."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from app.cli.main import run as command
from app.edits.documents import KeyFrame, Segment, TrackDoc
from app.recordings.annotation import corrected_rows
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server

FIRST, STOP = 3, 40


@pytest.fixture
def server(server_of_copy: Server) -> Server:
    """A server of the toy home, which these tests change."""
    return server_of_copy


def record(server: Server, run_id: str, **order: Any) -> dict[str, Any]:
    answer = server.client.post(f"/api/runs/{run_id}/recordings", json={"first": FIRST, "stop": STOP, **order})
    assert answer.status_code == 202, answer.text
    assert answer.json()["state"] == "queued"
    run_jobs(server.context, "recording")
    made: dict[str, Any] = server.client.get(f"/api/outputs/{answer.json()['id']}").json()
    return made


def test_tracks_have_the_names_of_the_page(server: Server, home: Any) -> None:
    place = server.context.evidence.stored_run(home.run_id)
    with server.context.evidence.reading(place) as reader:
        track = next(iter(reader.tracks()))
    middle = (track.first_frame + track.last_frame) // 2
    drawn = {"12": KeyFrame(box=(1, 1, 30, 30)), "7": KeyFrame(box=(1, 1, 30, 30))}
    half = Segment(track=track.track_id, first=middle, last=track.last_frame)
    made = (TrackDoc(key="h000001", keys=drawn), TrackDoc(key="h000002", segments=(half,)))
    documents = {doc.key: doc for doc in made}
    rows = corrected_rows(place.folder, documents, place.classes)
    assert rows is not None
    labels = set(rows.labels)
    for name in ("drawn at 7 ", f"#{track.track_id} from {middle} "):
        assert any(label.startswith(name) for label in labels), labels


def test_a_recording_has_corrections_and_ground_truth(server: Server, home: Any) -> None:
    with server.context.evidence.reading(server.context.evidence.stored_run(home.run_id)) as reader:
        track = next(iter(reader.tracks()))
    key = f"m{track.track_id}"
    edit = {"name": "set_box", "frame": track.first_frame + 2, "key": key, "box": [10.0, 10.0, 42.0, 42.0]}
    edit["spans"] = [{"track": track.track_id, "first": track.first_frame, "last": track.last_frame}]
    saved = server.client.post(
        f"/api/runs/{home.run_id}/edits",
        json={"op_id": "00000001", "author": "ada", "command": edit},
        headers={"If-Match": f'"{key}:0"'},
    )
    assert saved.status_code == 200, saved.text
    csv = "frame,track_id,x1,y1,x2,y2,class_id,visibility,ignore\n8,4,1,2,30,40,14,1,0\n"
    server.context.ground_truths.put(home.video_id, "exact", csv.encode())

    made = record(server, home.run_id, frame=8, track=key)
    assert made["state"] == "complete", made["error"]
    summary = made["summary"]
    assert (summary["first"], summary["stop"]) == (FIRST, STOP)
    assert "not re-encoded" in summary["picture"]
    assert summary["boxes"]["truth"] == 1
    assert summary["boxes"]["corrected"] > 0
    assert summary["edits"] == saved.json()["seq"]
    assert summary["tracks"][0] == track.track_id, "the track that it is about comes first"
    assert made["name"] == f"drive_{FIRST}-{STOP - 1}.rrd"
    file = server.client.get(f"/rerun/recordings/{made['id']}.rrd")
    assert file.status_code == 200
    assert len(file.content) == made["size"]
    assert file.content[:4] == b"RRF2"
    assert file.content == server.client.get(f"/api/outputs/{made['id']}/download").content
    listed = server.client.get("/api/outputs", params={"kind": "recording", "run": home.run_id}).json()["outputs"]
    assert [one["id"] for one in listed] == [made["id"]]


def test_without_its_video_a_recording_has_no_picture_and_says_so(server: Server, home: Any) -> None:
    from app.storage.models import Video

    with server.context.database.write() as session:
        session.get_one(Video, home.video_id).path = "/nowhere/drive.mp4"
    made = record(server, home.run_id)
    assert made["state"] == "complete", made["error"]
    assert made["summary"]["picture"] == "There is none, because the recording was made without the video."
    assert "corrected" not in made["summary"]["boxes"], "nobody has corrected anything"


def test_a_replaced_video_is_reported(server: Server, home: Any, tmp_path: Path) -> None:
    from app.storage.models import Video

    other = tmp_path / "drive.mp4"
    other.write_bytes(home.video.read_bytes()[:-1])
    with server.context.database.write() as session:
        session.get_one(Video, home.video_id).path = str(other)
    made = record(server, home.run_id)
    assert made["state"] == "failed"
    assert "is not the video of the run" in made["error"]


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"first": 9, "stop": 9}, "1 to 20000 frames"),
    ({"first": 0, "stop": 20001}, "1 to 20000 frames"),
    ({"first": 70, "stop": 76}, "has the frames 0 to 74"),
    ({"first": -1, "stop": 5}, "greater than or equal to 0"),
    ({"first": 1, "stop": 5, "track": "x"}, "match pattern"),
    ({"first": 1, "stop": 5, "other": 1}, "not permitted"),
]


def test_invalid_requests_are_refused(server: Server, home: Any) -> None:
    for order, words in WRONG:
        answer = server.client.post(f"/api/runs/{home.run_id}/recordings", json=order)
        assert answer.status_code == 422, order
        assert words in answer.json()["error"]["message"], order
    assert server.client.post(f"/api/runs/{'0' * 32}/recordings", json={"first": 0, "stop": 5}).status_code == 404
    assert server.client.get("/api/outputs").json()["outputs"] == []


def test_only_recordings_are_served_to_the_viewer(server: Server, home: Any) -> None:
    made = record(server, home.run_id)
    from app.storage.models import Output

    with server.context.database.write() as session:
        session.get_one(Output, made["id"]).kind = "export"
    assert server.client.get(f"/rerun/recordings/{made['id']}.rrd").status_code == 404


def test_the_command_line_makes_one_from_a_home_and_from_bare_evidence(
    server: Server, home: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "a.rrd"
    frames = ["--frames", f"{FIRST}:{STOP}", "--out", str(out)]
    assert command(["record", home.run_id, "--home", str(server.settings.home), *frames, "--json"]) == 0
    reported = json.loads(capsys.readouterr().out)
    assert (reported["stop"], reported["run"]) == (40, home.run_id)
    # by the video's name, without the folder of its run
    assert command(["record", "drive.mp4", "--home", str(server.settings.home), "--frames", "3:9999", *frames[2:]]) == 2
    error_output = " ".join(capsys.readouterr().err.split())
    assert "drive.mp4 means the run" in error_output
    assert "of drive.mp4 has stored the frames 0 to 74, so a range is within 0:75" in error_output
    assert str(home.folder.parent) not in error_output
    assert str(server.settings.home) not in error_output
    bare = tmp_path / "bare"
    shutil.copytree(home.folder, bare)
    assert command(["record", str(bare), *frames]) == 0
    assert "no picture" in capsys.readouterr().err
    assert command(["record", str(bare), "--video", str(home.video), *frames, "--at", "9", "--track", "1"]) == 0
    assert "not re-encoded" in capsys.readouterr().out
    for wrong, reported in (
        (["--at", "40"], "one of the recorded frames, 3 to 39"),
        (["--frames", "80:90", "--at", "5"], "has stored the frames 0 to 74"),
        (["--frames", "70:90", "--at", "80"], "has stored the frames 0 to 74"),
        (["--track", "99"], "number of one of the run's"),
        (["--track", "seven"], "number of one of the run's"),
    ):
        assert command(["record", str(bare), *frames, *wrong]) == 2
        assert reported in " ".join(capsys.readouterr().err.split())
    assert command(["record", str(bare), *frames, "--no-picture", "--track", "m1"]) == 0
    capsys.readouterr()
    assert command(["record", str(bare), "--out", str(tmp_path / "a.mp4")]) == 2
    assert "must end with .rrd" in capsys.readouterr().err
    assert command(["record", str(bare), "--frames", "3:9999", "--out", str(out)]) == 2
    assert "frames 0 to 74" in capsys.readouterr().err
