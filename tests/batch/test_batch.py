"""A batch on real processes: complete results, a second call without work, kills, invalid drives."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from sample_videos import SHIPPED
from tests.batch.forked_worker import fork_workers
from tests.batch.short_drives import write_short_drive
from tsr_engine.batch.manifest import MANIFEST, Identity, load_manifest
from tsr_engine.batch.process import run_task
from tsr_engine.batch.run import BatchProgress, BatchRequest, run_batch
from tsr_engine.batch.task import DriveTask, Outcome
from tsr_engine.batch.worker import unfinished_folder
from tsr_engine.cli.main import run
from tsr_engine.errors import UsageError
from tsr_engine.evidence import DEFAULT_CHUNK
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components
from tsr_engine.runs.track_video import RunRequest, track_video
from tsr_engine.version import __version__

pytestmark = pytest.mark.slow
PARAMS = Params().with_settings([("coast_foe_y", 0.5)])


@pytest.fixture(autouse=True)
def forked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Batches of this process fork the processes of drives; those of a command start them."""
    fork_workers(monkeypatch)


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two short drives, and a text file named like a video."""
    folder = tmp_path_factory.mktemp("drives")
    for name, frames in (("one", 16), ("two", 13)):
        write_short_drive(folder / f"{name}.mp4", frames)
    (folder / "text.mp4").write_text("no video")
    return folder


@pytest.fixture(scope="module")
def digests() -> dict[str, str]:
    return dict(load_components(PARAMS).models)


def request(drives: Path, out: Path, digests: dict[str, str], **facts: Any) -> BatchRequest:
    parameters = PARAMS.model_dump(mode="json")
    order = DriveTask("", "", parameters, digests=digests)
    paths = sorted(drives.glob("*.mp4"))
    return BatchRequest(paths, out, Identity(__version__, parameters, digests), order, **facts)


def go(wanted: BatchRequest) -> tuple[dict[str, tuple[str, str]], list[BatchProgress]]:
    reported: list[BatchProgress] = []
    manifest = run_batch(wanted, reported.append, lambda: False)
    return {drive.folder: (drive.state, drive.error) for drive in manifest.drives}, reported


def stamps(out: Path) -> dict[str, int]:
    return {str(p.relative_to(out)): p.stat().st_mtime_ns for p in out.glob("*/**/*")}


def test_a_batch_and_a_second_call(drives: Path, tmp_path: Path, digests: dict[str, str]) -> None:
    out, parts = tmp_path / "out", load_components(PARAMS)
    states, reported = go(request(drives, out, digests, jobs=2))
    assert states["one"] == states["two"] == ("done", "")
    assert states["text"][0] == "failed"
    assert "is not a video" in states["text"][1]
    assert (reported[-1].done, reported[-1].failed, reported[-1].total) == (2, 1, 3)
    for name in ("one", "two"):
        plain = tmp_path / f"{name}.csv"
        track_video(RunRequest(drives / f"{name}.mp4", PARAMS, csv=plain), parts)
        assert plain.read_bytes().count(b"\n") > 10, "there are signs to be found"
        assert (out / name / "tracks.csv").read_bytes() == plain.read_bytes()
        assert (out / name / "evidence" / "evidence.sqlite").is_file()
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["done"], summary["failed"], summary["frames"]) == (2, 1, 29)
    assert [row["drive"] for row in summary["failures"]] == [str(drives / "text.mp4")]
    assert "is not a video" in (out / "summary.html").read_text()

    before = stamps(out)
    assert go(request(drives, out, digests))[0] == states
    assert stamps(out) == before, "what is done is not done anew"

    other = replace(request(drives, out, digests).identity, version="0.0.1")
    with pytest.raises(UsageError, match=r"another batch \(version .*, not 0\.0\.1\)|another batch \(version 0\.0\.1"):
        go(replace(request(drives, out, digests), identity=other))

    shutil.rmtree(out / "one")
    assert go(request(drives, out, digests))[0] == states
    assert (out / "one" / "tracks.csv").is_file()
    assert {k: v for k, v in stamps(out).items() if k.startswith("two")} == {
        k: v for k, v in before.items() if k.startswith("two")
    }


def test_a_wanted_result_that_is_missing_is_made(drives: Path, tmp_path: Path, digests: dict[str, str]) -> None:
    (drive,) = paths = [drives / "two.mp4"]
    first = replace(request(drives, tmp_path, digests), drives=paths)
    assert go(replace(first, task=replace(first.task, csv=False)))[0] == {"two": ("done", "")}
    assert not (tmp_path / "two" / "tracks.csv").exists()
    assert go(first)[0] == {"two": ("done", "")}
    whole = (tmp_path / "two" / "tracks.csv").read_text().splitlines()
    (tmp_path / "two" / "tracks.csv").unlink()
    assert go(replace(first, ranges={drive: (0, 5)}))[0] == {"two": ("done", "")}
    part = (tmp_path / "two" / "tracks.csv").read_text().splitlines()
    assert {int(line.split(",")[0]) for line in part[1:]} <= set(range(5)), "other frames are other results"
    assert len(part) < len(whole)


def test_unfinished_work_on_other_frames_is_discarded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker refuses to continue evidence that begins at another frame."""
    drive, found = tmp_path / "drive.mp4", []
    drive.write_text("frames")

    def leave_unfinished(tasks: Sequence[DriveTask], *_: object) -> Iterator[tuple[int, Outcome]]:
        for index, task in enumerate(tasks):
            work = unfinished_folder(Path(task.folder))
            found.append(work.is_dir())
            work.mkdir(exist_ok=True)
            yield index, Outcome(None, "The process died.")

    monkeypatch.setattr("tsr_engine.batch.run.run_locally", leave_unfinished)
    wanted = replace(request(tmp_path, tmp_path / "out", {}), drives=[drive])
    for start in (0, 0, 5, 5):
        go(replace(wanted, ranges={drive: (start, None)}))
    drive.write_text("other frames")
    go(replace(wanted, ranges={drive: (5, None)}))
    assert found == [False, True, False, True, False]


def test_the_time_left_counts_what_this_call_has_tracked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A drive that fails at once takes no time, and a resumed drive begins in its middle."""
    for name in ("fails", "resumed", "waits"):
        (tmp_path / f"{name}.mp4").write_text("frames")
    clock = SimpleNamespace(now=0.0, monotonic=lambda: clock.now)

    def track(
        _tasks: Sequence[DriveTask], _jobs: int, update: Callable[[int, int, int], None], *_: object
    ) -> Iterator[tuple[int, Outcome]]:
        clock.now = 1.0
        yield 0, Outcome(None, "It is no video.")
        update(1, 15, 30)
        clock.now = 10.0
        update(1, 30, 30)
        yield 1, Outcome({})

    monkeypatch.setattr("tsr_engine.batch.run.run_locally", track)
    monkeypatch.setattr("tsr_engine.batch.run.time", clock)
    monkeypatch.setattr("tsr_engine.batch.run.write_summary", lambda *_: None)
    _, reported = go(request(tmp_path, tmp_path / "out", {}))
    assert [one.remaining for one in reported] == [None, 20.0]


def test_a_name_that_is_not_utf8_does_not_stop_a_batch(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "in").mkdir()
    name = os.fsdecode(b"caf\xe9.mp4")
    (tmp_path / "in" / name).write_text("no video")
    command = ["batch", str(tmp_path / "in"), "--out", str(tmp_path / "out")]
    for _ in range(2):  # the second call reads the manifest of the first
        assert run([*command, "--json"]) == 3
        (failure,) = json.loads(capfd.readouterr().out)["failures"]
        assert Path(failure["drive"]).name == name
    assert "caf\\udce9.mp4" in (tmp_path / "out" / "summary.html").read_text()


def test_models_that_an_earlier_call_had_are_compared(digests: dict[str, str]) -> None:
    parameters = PARAMS.model_dump(mode="json")
    fewer = {name: digest for name, digest in digests.items() if name != "prior"}
    before, now = (Identity(__version__, parameters, models) for models in (digests, fewer))
    assert now.differences(before) == before.differences(now) == ["another prior"]


def test_a_drive_continues_after_its_process_was_killed(tmp_path: Path, digests: dict[str, str]) -> None:
    folder = tmp_path / "out" / "drive"
    drive = write_short_drive(tmp_path / "drive.mp4", 60)
    order = DriveTask(str(drive), str(folder), PARAMS.model_dump(mode="json"), digests=digests)
    seen: list[subprocess.Popen[str]] = []

    def kill_later(done: int, total: int | None) -> None:
        if done > DEFAULT_CHUNK:
            seen[0].kill()

    assert run_task(order, kill_later, seen.append).died
    assert not folder.exists()
    assert (unfinished_folder(folder) / "evidence").is_dir()
    outcome = run_task(order)
    assert outcome.result is not None
    assert outcome.result["resumed_at"] > 0
    assert not unfinished_folder(folder).exists()
    plain = tmp_path / "plain.csv"
    track_video(RunRequest(drive, PARAMS, csv=plain), load_components(PARAMS))
    assert (folder / "tracks.csv").read_bytes() == plain.read_bytes()


def test_other_models_are_refused(drives: Path, tmp_path: Path, digests: dict[str, str]) -> None:
    order = DriveTask(
        str(drives / "one.mp4"), str(tmp_path / "x"), PARAMS.model_dump(mode="json"),
        digests={**digests, "detector": "0" * 64},
    )  # fmt: skip
    outcome = run_task(order)
    assert not outcome.died
    assert "has another detector than this work was started with" in outcome.error


def test_missing_models_are_reported(drives: Path, tmp_path: Path, digests: dict[str, str]) -> None:
    parameters, models = PARAMS.model_dump(mode="json"), str(tmp_path / "not_here")
    outcome = run_task(DriveTask(str(drives / "one.mp4"), str(tmp_path / "x"), parameters, models, digests))
    assert not outcome.died
    assert "not_here" in outcome.error
    assert "Unexpected" not in outcome.error


def test_a_folder_is_locked_by_one_batch(drives: Path, tmp_path: Path, digests: dict[str, str]) -> None:
    entered, leave = threading.Event(), threading.Event()

    def hold() -> bool:
        entered.set()
        leave.wait(60)
        return True

    first = threading.Thread(
        target=run_batch, args=(request(drives, tmp_path, digests), lambda _: None, hold), daemon=True
    )
    first.start()
    assert entered.wait(60)
    with pytest.raises(UsageError, match="Another batch writes"):
        go(request(drives, tmp_path, digests))
    leave.set()
    first.join(60)
    (tmp_path / MANIFEST).write_text("{")
    with pytest.raises(UsageError, match="is damaged"):
        load_manifest(tmp_path)
    (tmp_path / MANIFEST).write_text(json.dumps({"schema": 99}))
    with pytest.raises(UsageError, match="newer version"):
        load_manifest(tmp_path)


@pytest.mark.parametrize(
    ("options", "reported"),
    [
        (["--keep", "boxes"], "--keep expects some of evidence, csv, video. Got 'boxes'"),
        (["--on", "mars"], "--on expects local, ray or ray://HOST:PORT"),
        (["--set", "tau=x"], "tau"),
    ],
)
def test_wrong_options_are_refused(
    drives: Path, tmp_path: Path, options: list[str], reported: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(["batch", str(drives), "--out", str(tmp_path), *options]) == 2
    assert reported in capfd.readouterr().err


def test_a_failed_drive_is_named_once(drives: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    drive = str(drives / "text.mp4")
    assert run(["batch", drive, "--out", str(tmp_path / "out")]) == 3
    assert capfd.readouterr().err.count(drive) == 1


def test_ctrl_c_keeps_finished_drives(drives: Path, tmp_path: Path) -> None:
    for number in range(3):
        shutil.copy(SHIPPED[0].video, tmp_path / f"long{number}.mp4")
    (tmp_path / "a.mp4").write_bytes((drives / "two.mp4").read_bytes())
    command = ["batch", str(tmp_path), "--out", str(tmp_path / "out"), "--jobs", "1", "--set", "coast_foe_y=0.5"]
    process = subprocess.Popen(
        [sys.executable, "-m", "tsr_engine", *command], stderr=subprocess.PIPE, text=True, start_new_session=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )  # fmt: skip
    until = time.monotonic() + 120
    while not (tmp_path / "out" / "a").is_dir():
        assert time.monotonic() < until
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Finished drives are kept" in said
    manifest = load_manifest(tmp_path / "out")
    assert manifest is not None
    assert "waiting" in {drive.state for drive in manifest.drives}
    before = stamps(tmp_path / "out" / "a")
    for number in range(3):
        (tmp_path / f"long{number}.mp4").unlink()
    assert run(command) == 0
    assert stamps(tmp_path / "out" / "a") == before, "what had just become whole is not done anew"
