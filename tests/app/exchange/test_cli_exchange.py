"""``tsr export``, ``tsr import``, ``tsr formats``: every failure is one sentence with a fixed exit code."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import zipfile
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.cli.data_folder import describe_run_choice, find_run, open_home
from app.cli.main import run as tsr
from app.settings import DATABASE_FILE, MAKE_HOME
from app.storage.models import Run
from tests.app.exchange.exchange_client import ExchangeClient, assert_same_track, clipped_to_picture
from tests.app.toy_home import ToyHome
from tsr_engine.exchange.registry import FORMATS


@pytest.fixture
def home(api: ExchangeClient, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A data folder with corrections, independent of the machine's settings."""
    for name in [name for name in os.environ if name.startswith("TSR_")]:
        monkeypatch.delenv(name)
    api.make_corrections()
    return api.home


def answer(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    """The JSON output of a command that succeeds."""
    capsys.readouterr()
    assert tsr([*arguments, "--json"]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)


def error_message(capsys: pytest.CaptureFixture[str], code: int, *arguments: str) -> str:
    """The one sentence of a command that fails."""
    capsys.readouterr()
    assert tsr(list(arguments)) == code, capsys.readouterr()
    reported = capsys.readouterr()
    assert reported.out == ""
    assert reported.err.startswith("tsr: ")
    assert reported.err.count("\n") == 1
    return reported.err


def test_formats_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    found = answer(capsys, "formats")
    assert [each["name"] for each in found["formats"]] == list(FORMATS)
    assert tsr(["formats"]) == 0
    assert "cvat-video" in capsys.readouterr().out


def test_a_run_and_a_video_are_exported_with_corrections(
    api: ExchangeClient, home: Path, tracked_home: ToyHome, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, folder = tmp_path / "a.zip", tmp_path / "signs"
    for name in (api.run_id, api.video_id, str(tracked_home.video), "drive.mp4", str(home / "runs" / api.run_id)):
        found = answer(capsys, "export", name, "--home", str(home), "--format", "cvat-video", "--out", str(out))
        assert found["counts"]["tracks"] == 2, name
        assert found["videos"][0]["edit_revision"] == 9
    assert zipfile.ZipFile(out).testzip() is None
    arguments = ["export", api.run_id, "--home", str(home), "--format", "yolo", "--out", str(folder)]
    more = ["--pictures", "annotated", "--frames", "0:20", "--states", "open", "--option", "empty=no"]
    known = {switch.name for switch in FORMATS["yolo"].export_switches}
    assert tsr([*arguments, *(more if "empty" in known else more[:-2])]) == 0
    assert (folder / "manifest.json").is_file()
    assert list(folder.rglob("*.jpg"))


def test_an_export_of_a_video_names_its_run(
    api: ExchangeClient, home: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wanted = ["--home", str(home), "--format", "tracks-csv", "--json"]
    for name, reported in (("drive.mp4", True), (api.run_id, False)):
        capsys.readouterr()
        assert tsr(["export", name, *wanted, "--out", str(tmp_path / name)]) == 0
        captured = capsys.readouterr()
        json.loads(captured.out)
        assert captured.err.startswith("tsr: drive.mp4 means the run") == reported
        assert (f"({api.run_id})." in captured.err) == reported
    # a newer uncorrected run is chosen, and the message names the corrected one
    with open_home(home) as (_, database), database.write() as session:
        corrected = session.get_one(Run, api.run_id)
        columns = {c.name: getattr(corrected, c.name) for c in Run.__table__.columns}
        later = {"id": "f" * 32, "name": "again", "created": corrected.created - timedelta(hours=1)}
        later["order"] = corrected.order + 1
        session.add(Run(**{**columns, **later}))
        session.flush()
        reported_now = describe_run_choice(session, find_run(session, "drive.mp4"))
        session.rollback()
    assert (
        f"the run 'again' of {later['created']:%Y-%m-%d %H:%M} UTC ({'f' * 32}), which has no corrections"
        in reported_now
    )
    assert f"({api.run_id}): give its id" in reported_now


def test_a_bare_evidence_folder_is_exported_without_a_data_folder(
    tracked_home: ToyHome, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    import shutil

    monkeypatch.setenv("TSR_HOME", str(tmp_path / "none"))
    bare = shutil.copytree(tracked_home.folder, tmp_path / "run1")
    out = tmp_path / "bare.zip"
    found = answer(capsys, "export", str(bare), "--format", "cvat-video", "--out", str(out))
    assert found["counts"]["tracks"] == 2
    assert found["videos"][0]["edit_revision"] == 0
    arguments = ["export", str(bare), "--format", "cvat-images", "--out", str(out), "--pictures", "annotated"]
    assert "cannot be read" in error_message(capsys, 7, *arguments)
    assert tsr([*arguments, "--video", str(tracked_home.video)]) == 0
    assert any(name.endswith((".jpg", ".png")) for name in zipfile.ZipFile(out).namelist())
    assert not (tmp_path / "none").exists()


def test_imports_as_ground_truth_run_and_annotation(
    api: ExchangeClient, home: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "a.zip"
    assert tsr(["export", api.run_id, "--home", str(home), "--format", "cvat-video", "--out", str(out)]) == 0
    onto = ["import", str(out), "--onto", "drive.mp4", "--home", str(home), "--as"]
    truth = answer(capsys, *onto, "truth")
    assert truth["tracks"] == 2
    assert [item["what"] for item in truth["skipped"]] == ["1 rejected track", "1 note"]
    assert [t["name"] for t in api.get(f"/api/videos/{api.video_id}/ground-truths")["ground_truths"]] == ["a.zip"]
    same = answer(capsys, *onto, "annotation", "--run", api.run_id)
    assert (same["same"], same["tracks"], same["edit"]) == (3, 0, None)
    for named, reported in (((), True), (("--run", api.run_id), False)):
        assert tsr([*onto, "annotation", *named]) == 0
        assert ("drive.mp4 means the run" in capsys.readouterr().err) == reported
    made = answer(capsys, *onto, "run", "--name", "theirs")
    assert api.get(f"/api/runs/{made['id']}")["name"] == "theirs"
    imported = api.tracks(made["id"]).values()
    assert {track.source for track in imported} == {"imported"}
    for wanted in (clipped_to_picture(track) for track in api.tracks().values()):
        twin = next(track for track in imported if np.array_equal(track.frames, wanted.frames))
        assert abs(twin.boxes - wanted.boxes).max() < 0.51
        assert twin.occluded.tolist() == wanted.occluded.tolist()
        assert (twin.state, twin.notes) == (wanted.state, wanted.notes)
    assert tsr([*onto, "truth", "--name", "again"]) == 0
    assert "became ground truth" in capsys.readouterr().out
    # a video still stands for the engine's run, even if another run was imported later
    answer(capsys, "export", "drive.mp4", "--home", str(home), "--format", "coco", "--out", str(tmp_path / "b"))
    content = json.loads((tmp_path / "b" / "manifest.json").read_text())
    assert [video["provenance"]["run"]["id"] for video in content["videos"]] == [api.run_id]
    assert next(v for v in api.get("/api/videos")["videos"] if v["id"] == api.video_id)["latest_run"] == api.run_id


EXPORT = ["export", "RUN", "--format", "cvat-video", "--out", "OUT"]


@pytest.mark.parametrize(
    ("code", "arguments", "words"),
    [
        (2, ["export", "RUN", "--format", "papyrus", "--out", "OUT"], "There is no format"),
        (2, [*EXPORT, "--split", "a"], "--split expects"),
        (2, [*EXPORT, "--pictures", "some"], "--pictures cannot be"),
        (2, [*EXPORT, "--classes", "stop"], "--classes expects"),
        (2, [*EXPORT, "--classes", "77"], "alias or number '77'. The page Labels"),
        (2, [*EXPORT, "--labels", "stopp"], "'stopp'. Is it 'stop'?"),
        (2, [*EXPORT, "--option", "colour"], "NAME=VALUE"),
        (2, [*EXPORT, "--option", "a=b"], "no option"),
        (2, [*EXPORT, "--video", "VIDEO"], "--video names"),
        (2, ["export", "RUN", "RUN", "--format", "cvat-video", "--out", "OUT"], "one run per video"),
        (2, ["export", "RUN", "--format", "cvat-video"], "--out"),
        (3, ["export", "elsewhere.mp4", "--format", "cvat-video", "--out", "OUT"], "There is no run"),
        (3, ["export", "f" * 64, "--format", "cvat-video", "--out", "OUT"], "is not in the data folder"),
        (6, ["export", "RUN", "--format", "cvat-video", "--out", "FILE/x"], "Cannot write"),
        (2, ["import", "FILE", "--onto", "VIDEO", "--as", "poem"], "--as must be"),
        (2, ["import", "FILE", "--onto", "VIDEO", "--as", "truth", "--run", "RUN"], "--run is for"),
        (3, ["import", "FILE", "--onto", "VIDEO", "--as", "truth"], "matches none of"),
        (3, ["import", "absent.xml", "--onto", "VIDEO", "--as", "truth"], "There is no file at"),
        (
            3,
            ["import", "FILE", "--onto", "elsewhere.mp4", "--as", "truth"],
            "There is no run, evidence folder or video",
        ),
    ],
)
def test_bad_input_is_one_sentence(
    read_only_api: ExchangeClient,
    tracked_home: ToyHome,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    code: int,
    arguments: list[str],
    words: str,
) -> None:
    file = tmp_path / "file.xml"
    file.write_bytes(b"hello")
    names = {"RUN": read_only_api.run_id, "VIDEO": str(tracked_home.video), "OUT": str(tmp_path / "out.zip")}
    names |= {"FILE": str(file), "FILE/x": str(file / "x.zip")}
    given = [names.get(argument, argument) for argument in arguments]
    assert words in error_message(capsys, code, *given, "--home", str(read_only_api.home))
    assert [path.name for path in tmp_path.iterdir()] == ["file.xml"], "nothing was written"


def test_without_a_data_folder_nothing_is_created(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    nowhere = tmp_path / "nowhere"
    reported = error_message(
        capsys, 3, "export", "drive.mp4", "--home", str(nowhere), "--format", "cvat-video", "--out", str(tmp_path / "o")
    )
    assert "There is no data folder" in reported
    assert not nowhere.exists()


def test_the_library_of_make_review_is_suggested(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "share"))
    monkeypatch.delenv("TSR_HOME", raising=False)
    monkeypatch.chdir(tmp_path)
    asked = ("export", "drive.mp4", "--format", "cvat-video", "--out", "o")
    assert "or start 'tsr review' once." in error_message(capsys, 3, *asked)
    (tmp_path / MAKE_HOME).mkdir(parents=True)
    assert "or start 'tsr review' once." in error_message(capsys, 3, *asked), "a folder alone is no library"
    (tmp_path / MAKE_HOME / DATABASE_FILE).touch()
    for command in (asked, ("models", "list")):
        reported = error_message(capsys, 3, *command)
        assert "There is one of 'make review' here: name it with --home out/review." in reported
        assert "start 'tsr review'" not in reported
    for name, says in (
        ("Makefile", f"HOME_DIR ?= {MAKE_HOME.as_posix()}\n"),
        ("README.md", f"`--home {MAKE_HOME.as_posix()}`"),
    ):
        assert says in (Path(__file__).parents[3] / name).read_text(encoding="utf-8")


def test_a_killed_export_keeps_the_old_one(api: ExchangeClient, home: Path, tmp_path: Path) -> None:
    out = tmp_path / "signs"
    arguments = ["export", api.run_id, "--home", str(home), "--format", "cvat-images", "--out", str(out)]
    arguments += ["--pictures", "all", "--frames", "0:40"]
    assert tsr(arguments) == 0
    before = {path.relative_to(out): path.read_bytes() for path in out.rglob("*") if path.is_file()}
    code = "import sys; from app.cli.main import run; sys.exit(run())"
    command = [sys.executable, "-c", code, *arguments]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        until = time.monotonic() + 120
        while not list(tmp_path.glob(".signs.*.part/export/*")):
            assert process.poll() is None, "it was too fast to be killed"
            assert time.monotonic() < until
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
    now = {path.relative_to(out): path.read_bytes() for path in out.rglob("*") if path.is_file()}
    assert now == before
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".signs")]
    assert tsr(arguments) == 0
    assert not [path.name for path in tmp_path.iterdir() if path.name.startswith(".signs")], "no rubbish"


def test_tracks_round_trip(api: ExchangeClient, home: Path, tmp_path: Path) -> None:
    """From one data folder to the unchanged run of another."""
    out = tmp_path / "a.zip"
    states = ["--states", "open,accepted,needs_work,rejected"]
    arguments = ["export", api.run_id, "--home", str(home), "--format", "cvat-video", "--out", str(out), "--thin", "0"]
    assert tsr([*arguments, *states]) == 0
    wanted = {key: clipped_to_picture(track) for key, track in api.tracks().items()}
    for _ in api.get(f"/api/runs/{api.run_id}/edits")["edits"]:
        api.undo()
    assert (api.tracks()["m1"].label, "hdrawn01" in api.tracks()) == (14, False)
    given = ["import", str(out), "--onto", api.video_id, "--home", str(home), "--as", "annotation", "--run"]
    assert tsr([*given, api.run_id]) == 0
    found = api.tracks()
    # unchanged boxes stay the engine's, which may reach beyond the picture
    assert_same_track(clipped_to_picture(found["m1"]), wanted["m1"], 0.51)
    drawn = next(track for key, track in found.items() if key.startswith("h"))
    assert_same_track(drawn, wanted["hdrawn01"], 0.51)
