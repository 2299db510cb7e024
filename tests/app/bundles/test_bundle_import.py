"""A bundle is imported completely under the clip's frame numbers, or not at all."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.bundles import importing
from app.edits.commands import Undo
from app.errors import Busy
from app.exchange.tracks import run_tracks
from app.outputs.file_moves import sweep
from app.storage.models import Event, Run, Video
from tests import toy_pipeline
from tests.app.bundles.toy_bundle import FIRST, STOP, WRONG, ToyBundle
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server
from tsr_engine.bundle import bundle_params, make_bundle, open_bundle, replay_bundle
from tsr_engine.bundle.request import BundleRequest
from tsr_engine.evidence import EvidenceReader
from tsr_engine.io.video import open_video

START = 3
"""Frame of the drive that the engine starts with."""


def bring_in(server: Server, path: Path) -> Any:
    return server.client.post("/api/bundles", content=path.read_bytes())


def counts(server: Server) -> tuple[int, int]:
    with server.context.database.read() as session:
        return session.query(Video).count(), session.query(Run).count()


def leftovers(server: Server) -> list[str]:
    home = server.settings.home
    return [str(p.relative_to(home)) for place in ("runs", "uploads") for p in (home / place).glob("*")]


def test_an_imported_bundle_replays_unchanged(bundled: ToyBundle, server: Server, tmp_path: Path) -> None:
    answer = bring_in(server, bundled.path)
    assert answer.status_code == 201, answer.text
    reported = answer.json()
    report, run_id, video_id = reported["report"], reported["run"]["id"], reported["video"]["id"]
    offset = report["offset"]
    assert offset == 0  # the drive has one key frame, its first frame
    assert (report["first"], report["stop"]) == (FIRST - offset, STOP - offset)
    assert (report["note"], report["corrections"], report["other_pictures"]) == ("reads as a stop sign", 2, 0)
    assert [one["met"] for one in report["expected"]] == [False, False, False, True]
    # unmet expectations, in the last frame of the clip that shows the sign
    assert report["track"] == report["expected"][0]["id"].split(".")[0]
    assert report["first"] <= report["frame"] < report["stop"]
    assert (reported["run"]["kind"], reported["run"]["state"], reported["run"]["first"]) == (
        "engine",
        "complete",
        START,
    )
    assert reported["run"]["parameters"] == {"tau": 3.0, "coast_foe_y": 0.5}
    assert reported["run"]["summary"]["focus"] == {"x": 0.5, "y": 0.5, "named": True}
    assert not reported["video"]["missing"], "the answer is given when the clip is in its place"
    with server.context.database.read() as session:
        events = [event.data for event in session.query(Event).where(Event.kind == "video")]
    assert [event["missing"] for event in events] == [False], "so are all that pages are informed"
    run_jobs(server.context, "import")
    view = server.client.get(f"/api/videos/{video_id}").json()
    assert (view["state"], view["missing"], view["name"]) == ("ready", False, "drive 46-69.mp4")

    # the evidence equals the run's
    folder = server.settings.home / "runs" / run_id
    with EvidenceReader(folder) as imported, bundled.home.reader() as original:
        assert (imported.first_frame, imported.last_frame, imported.header.video.sha256) == (START, STOP - 1, video_id)
        for a, b in zip(imported.frames(), original.frames(START, STOP), strict=True):
            assert a.ordinal == b.ordinal - offset
            for x, y in zip(a.tracks, b.tracks, strict=True):
                assert (x.track_id, x.source, x.state) == (y.track_id, y.source, y.state)
                assert np.array_equal(x.box, y.box)
            assert len(a.regions) == len(b.regions)

    # corrections are edits, reverted by one undo
    annotation = server.client.get(f"/api/runs/{run_id}/annotation").json()
    documents = {document["key"]: document for document in annotation["docs"]}
    assert set(documents) == {"habcdef", "m2"}
    assert documents["m2"]["class_id"] == WRONG
    assert documents["m2"]["notes"][0]["text"] == "look at this"
    assert sorted(documents["habcdef"]["keys"], key=int) == ["40", "56", "62"]
    assert annotation["undo"]["name"] == "import_bundle"
    log = server.client.get(f"/api/runs/{run_id}/edits").json()["edits"]
    assert [(row["name"], row["frame"], row["keys"]) for row in log] == [
        ("import_bundle", report["first"], ["habcdef", "m2"])
    ]
    assert {document["revision"] for document in documents.values()} == {1}
    edits = server.context.edits
    undo = Undo(name="undo", op_id=annotation["undo"]["op_id"])
    back = edits.apply(run_id, "undo-of-the-import", "ada", undo, None)
    assert {doc.key: (doc.class_id, doc.gone) for doc in back.docs} == {"habcdef": (None, True), "m2": (None, False)}

    # a bundle of the imported run replays like the first
    with server.context.database.read() as session:
        clip = Path(session.get_one(Video, video_id).path)
    again = make_bundle(BundleRequest(folder, clip, tmp_path / "second.zip", FIRST, STOP, recording=False))
    with open_bundle(again.path) as bundle:
        params, _ = bundle_params(bundle)
        replayed = replay_bundle(bundle, params, toy_pipeline.components(params))
    assert replayed.same
    assert replayed.identical == STOP - FIRST, replayed.first_difference


def test_frame_numbers_of_a_clip_from_the_middle(bundled: ToyBundle, server: Server, tmp_path: Path) -> None:
    """The drive has many key frames, so the clip begins in the middle and all numbers shift."""
    from fractions import Fraction

    from app.edits.documents import KeyFrame, Segment, TrackDoc
    from tsr_engine.io.video_writer import VideoWriter
    from tsr_engine.runs.track_video import RunRequest, track_video

    video = tmp_path / "keys.mp4"
    with VideoWriter(video, toy_pipeline.WIDTH, toy_pipeline.HEIGHT, Fraction(25), key_distance=8) as writer:
        for k in range(66):
            writer.write(toy_pipeline.drive_picture(k))
    track_video(RunRequest(video, toy_pipeline.PARAMS, tmp_path / "run", start=38), toy_pipeline.components())
    with EvidenceReader(tmp_path / "run") as reader:
        tracks = [track for track in reader.tracks() if track.confirmed]
        quiet = reader.last_empty_frame(before=50)
    assert quiet is not None
    first, stop = quiet + 4, quiet + 14
    last = tracks[-1]
    document = TrackDoc(
        key=f"m{last.track_id}",
        class_id=WRONG,
        segments=(Segment(track=last.track_id, first=last.first_frame, last=last.last_frame),),
        keys={str(first + 1): KeyFrame(box=(5.0, 5.0, 20.0, 20.0))},
    )
    ended = TrackDoc(
        key="m99",
        segments=(Segment(track=99, first=0, last=first - 1),),
        keys={str(first + 2): KeyFrame(box=(5.0, 5.0, 20.0, 20.0))},
    )
    corrections = {"documents": [each.model_dump(mode="json") for each in (document, ended)]}
    made = make_bundle(
        BundleRequest(
            tmp_path / "run", video, tmp_path / "b.zip", first, stop, corrections=corrections, recording=False
        )
    )
    reported = bring_in(server, made.path).json()
    offset = reported["report"]["offset"]
    assert 0 < offset <= quiet
    assert offset % 8 == 0
    assert (reported["run"]["first"], reported["run"]["stop"]) == (quiet - offset, stop - offset)
    documents = server.client.get(f"/api/runs/{reported['run']['id']}/annotation").json()["docs"]
    assert list(documents[0]["keys"]) == [str(first + 1 - offset)]
    assert documents[0]["segments"][0]["last"] == min(last.last_frame, stop - 1) - offset
    assert (documents[1]["key"], list(documents[1]["keys"])) == ("m99", [str(first + 2 - offset)])
    shown = {
        track.uid: track.frames.tolist()
        for track in run_tracks(
            server.settings.home / "runs" / reported["run"]["id"],
            {doc["key"]: TrackDoc.model_validate(doc) for doc in documents},
            0,
            stop - offset,
            stop - offset,
        )
    }
    assert shown["m99"] == [first + 2 - offset], "a box drawn after the end of an engine track"
    assert reported["run"]["tracks"] == len(shown)
    with server.context.database.read() as session:
        clip = Path(session.get_one(Video, reported["video"]["id"]).path)
    with open_video(clip) as imported, open_video(video) as original:
        assert np.array_equal(imported.read(first - offset).picture, original.read(first).picture)


def test_a_second_import_adds_a_run_to_the_video(bundled: ToyBundle, server: Server) -> None:
    one, two = bring_in(server, bundled.path).json(), bring_in(server, bundled.path).json()
    assert one["video"]["id"] == two["video"]["id"]
    assert one["run"]["id"] != two["run"]["id"]
    assert counts(server) == (1, 2)


# A server that takes a bundle in and dies by SIGKILL between the last file and the commit.
KILLED = """
import os, signal, sys
from pathlib import Path
from app.outputs import file_moves
from app.context import build_context
from app.settings import Settings
home, path, work = map(Path, sys.argv[1:])
put = file_moves.FileMoves.move
def put_and_die(self, source, place):
    put(self, source, place)
    if place.parent.name == "runs":
        os.kill(os.getpid(), signal.SIGKILL)
file_moves.FileMoves.move = put_and_die
work.mkdir(parents=True)
build_context(Settings(home=home)).bundle_imports.import_bundle(path, work, "ada")
"""


def test_a_kill_between_files_and_commit_leaves_nothing(bundled: ToyBundle, tmp_path: Path) -> None:
    home = tmp_path / "other"
    with Server(home).client:
        pass  # creates the database
    (home / "runs").mkdir(exist_ok=True)
    (home / "runs" / f".placing-{'0' * 32}").write_text('{"run": "cut o')  # killed while writing its note
    work = home / "uploads" / ".import-abc" / "work"
    done = subprocess.run(
        [sys.executable, "-c", KILLED, str(home), str(bundled.path), str(work)],
        stderr=subprocess.PIPE, timeout=500, check=False, env={**os.environ, "TSR_HOME": str(home)},
    )  # fmt: skip
    assert done.returncode == -signal.SIGKILL, done.stderr.decode()
    left = {name.split("/")[0] for name in map(str, (p.relative_to(home) for p in home.glob("[ru]*/*")))}
    assert left == {"runs", "uploads"}, "the test must leave something to clean up"
    again = Server(home)
    with again.client:
        assert leftovers(again) == []
        assert counts(again) == (0, 0)


def test_a_committed_import_with_a_leftover_note_is_kept(bundled: ToyBundle, server: Server) -> None:
    reported = bring_in(server, bundled.path).json()
    kept = leftovers(server)
    note = {"run": reported["run"]["id"], "upload": Path(reported["video"]["path"]).name}
    (server.settings.home / "runs" / f".placing-{reported['run']['id']}").write_text(json.dumps(note))
    sweep(server.settings.home, server.context.database)
    assert sorted(leftovers(server)) == sorted(kept)
    assert {Path(name).parts[0] for name in kept} == {"runs", "uploads"}


def test_a_failed_import_removes_its_files(bundled: ToyBundle, server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any) -> None:
        raise Busy("The database is busy.")

    monkeypatch.setattr(importing, "publish_run", fail)
    assert bring_in(server, bundled.path).status_code == 503
    assert counts(server) == (0, 0)
    assert leftovers(server) == []


def test_a_missing_video_file_is_restored(bundled: ToyBundle, server: Server) -> None:
    video = bring_in(server, bundled.path).json()["video"]
    Path(video["path"]).unlink()
    again = bring_in(server, bundled.path).json()["video"]
    assert (again["id"], again["missing"]) == (video["id"], False)
    assert hashlib.sha256(Path(again["path"]).read_bytes()).hexdigest() == video["id"]


def rewrite(bundled: ToyBundle, out: Path, change: Callable[[dict[str, bytes]], None]) -> Path:
    with zipfile.ZipFile(bundled.path) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    change(content)
    manifest = json.loads(content["manifest.json"])
    files = [(name, data) for name, data in sorted(content.items()) if name != "manifest.json"]
    manifest["files"] = [{"name": n, "size": len(d), "sha256": hashlib.sha256(d).hexdigest()} for n, d in files]
    manifest["clip"]["sha256"] = hashlib.sha256(content["clip.mp4"]).hexdigest()
    content["manifest.json"] = json.dumps(manifest).encode()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    return out


def no_video(content: dict[str, bytes]) -> None:
    content["clip.mp4"] = b"\0\0\0\x18ftypmp42" + bytes(500)


def add_escaping_name(content: dict[str, bytes]) -> None:
    content["../../escaped"] = b"x"


def no_document(content: dict[str, bytes]) -> None:
    content["corrections.json"] = b'{"format": 1, "documents": [{"key": "m1; drop table"}]}'


def zeros_in_front(content: dict[str, bytes]) -> None:
    content["corrections.json"] = b'{"format": 1, "documents": [{"key": "m007", "class_id": -1}], "labels": {}}'


def zeros_in_a_merge(content: dict[str, bytes]) -> None:
    document = b'{"key": "m7", "gone": true, "merged_into": "m01"}'
    content["corrections.json"] = b'{"format": 1, "documents": [%s], "labels": {}}' % document


def no_database(content: dict[str, bytes]) -> None:
    content["evidence/evidence.sqlite"] = b"SQLite format 3\0" + bytes(4000)


@pytest.mark.parametrize(
    ("change", "words", "status"),
    [
        (no_video, "clip.mp4", 422),
        (add_escaping_name, "leads out of its folder", 400),
        (no_document, "corrections.json, document 0.key", 422),
        (zeros_in_front, "corrections.json, document m007: the number", 422),
        (zeros_in_a_merge, "corrections.json, document m01: the number", 422),
        (no_database, "evidence", 422),
    ],
)
def test_an_import_is_never_partial(
    bundled: ToyBundle, server: Server, tmp_path: Path, change: Any, words: str, status: int
) -> None:
    answer = bring_in(server, rewrite(bundled, tmp_path / "bad.zip", change))
    assert answer.status_code == status, answer.text
    error = answer.json()["error"]
    assert error["code"] == "bad_bundle"
    assert words in error["message"]
    assert error["message"].endswith("Nothing was imported.")
    assert str(server.settings.home) not in error["message"]
    assert counts(server) == (0, 0)
    assert leftovers(server) == []
    assert not list(tmp_path.rglob("escaped"))


def test_invalid_bodies_are_refused(server: Server) -> None:
    assert server.client.post("/api/bundles", content=b"").status_code == 422
    answer = server.client.post("/api/bundles", content=b"hello")
    assert (answer.status_code, answer.json()["error"]["code"]) == (422, "bad_bundle")
    assert "bundle.zip is not a ZIP archive. Choose a file made by 'tsr bundle' or by 'Report a bug'." in answer.text
    for name in ("work", "sent", "bundle"):
        assert server.client.post("/api/bundles", params={"name": name}, content=b"hello").status_code == 422
    named = server.client.post("/api/bundles", params={"name": "wet/road (2).zip"}, content=b"hello")
    assert "wet_road (2).zip" in named.json()["error"]["message"]
    assert server.stranger().post("/api/bundles", content=b"hello").status_code == 401
    assert leftovers(server) == []


def test_an_import_over_http(bundled: ToyBundle) -> None:
    home = bundled.home
    server = Server(home.settings.home, roots=(home.video.parent,))
    with server.client as client:
        url = f"/api/runs/{home.run_id}/bundles"
        answer = client.post(url, json={"first": 60, "stop": 64, "note": "here", "tracks": ["m2"]})
        assert answer.status_code == 202, answer.text
        assert answer.json()["options"]["tracks"] == ["m2"]
        assert client.post(f"/api/outputs/{answer.json()['id']}/cancel").status_code == 202
        assert client.post(url, json={"first": 60}).status_code == 422
        listed = client.get("/api/outputs?kind=bundle").json()["outputs"]
        done = next(one for one in listed if one["state"] == "complete")
        content = client.get(f"/api/outputs/{done['id']}/download").content
    assert content == bundled.path.read_bytes()
