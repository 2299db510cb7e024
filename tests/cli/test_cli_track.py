"""`tsr track` and `tsr replay` on the toy drive."""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
import time
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import NamedTuple

import pytest

import tsr_engine.pipeline
from tests import toy_pipeline
from tsr_engine.cli.main import run
from tsr_engine.compilation import COMPILING
from tsr_engine.errors import EvidenceError
from tsr_engine.evidence import EvidenceReader
from tsr_engine.io.video import open_video


class CommandResult(NamedTuple):
    returncode: int
    stdout: str
    stderr: str


TOY_CLI = Path(__file__).with_name("toy_cli.py")
FRAMES = 60


def tsr(*arguments: object) -> CommandResult:
    """Run the command line in this process with toy parts."""
    out, err = io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.setattr(tsr_engine.pipeline, "load_components", toy_pipeline.load_components)
        code = run([str(argument) for argument in arguments])
    return CommandResult(code, out.getvalue(), err.getvalue())


def assert_one_sentence(done: CommandResult, code: int, *words: str) -> None:
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr + done.stdout
    lines = [line for line in done.stderr.splitlines() if line]
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("tsr: ")
    for word in words:
        assert word in lines[0]


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path: Path = toy_pipeline.write_drive(tmp_path_factory.mktemp("cli") / "drive.mp4", FRAMES)
    return path


@pytest.fixture(scope="module")
def tracked(drive: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, CommandResult]:
    folder = tmp_path_factory.mktemp("tracked")
    done = tsr("track", drive, "--csv", folder / "rows.csv", "--evidence", folder / "run", "--set", "tau=3", "--json")
    assert done.returncode == 0, done.stderr
    return folder, done


def test_track_writes_rows_and_prints_json(tracked: tuple[Path, CommandResult]) -> None:
    folder, done = tracked
    assert done.stderr in ("", f"tsr: {COMPILING.capitalize()}.\n")
    report = json.loads(done.stdout)
    assert report["frames"] == FRAMES
    assert [t["track_id"] for t in report["tracks"]] == [1, 2]
    assert report["timing_ms"]["detect"]["frames"] == FRAMES
    lines = (folder / "rows.csv").read_text().splitlines()
    assert lines[0] == "frame,track_id,x1,y1,x2,y2,class_id,score,source"
    assert {line.split(",")[-1] for line in lines[1:]} <= {"detected", "predicted", "relocalised"}


def test_track_without_outputs_prints_a_table_and_timing(drive: Path) -> None:
    done = tsr("track", drive, "--frames", ":20", "--timing")
    assert done.returncode == 0, done.stderr
    assert "20 frames of 320x240, 1 sign" in done.stdout
    assert "4-19" in done.stdout
    assert "median ms" in done.stdout


def test_a_name_is_printed_as_it_is(drive: Path, tmp_path: Path) -> None:
    named = tmp_path / "drive [front] :car:.mp4"
    named.write_bytes(drive.read_bytes())
    done = tsr("track", named, "--frames", ":3")
    assert done.stdout.startswith(f"{named.name}: 3 frames"), done


@pytest.mark.parametrize("words", [[], ["--json"]])
def test_a_name_that_is_not_utf8_is_escaped(drive: Path, tmp_path: Path, words: list[str]) -> None:
    named = tmp_path / os.fsdecode(b"caf\xe9.mp4")
    named.write_bytes(drive.read_bytes())
    command = [sys.executable, TOY_CLI, "track", named, "--frames", ":3", "--video", named.with_suffix(".seen.mp4")]
    done = subprocess.run([*command, *words], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    shown = json.loads(done.stdout)["video"] if words else done.stdout.partition(": ")[0]
    assert shown == (named.name if words else "caf\\udce9.mp4")


def test_replay_gives_the_same_rows_and_shows_what_changes(tracked: tuple[Path, CommandResult], tmp_path: Path) -> None:
    folder, _ = tracked
    done = tsr("replay", folder / "run", "--csv", tmp_path / "rows.csv", "--json")
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["identical_frames"] == report["frames"] == FRAMES
    assert report["missing_pixels"] == 0
    assert (tmp_path / "rows.csv").read_bytes() == (folder / "rows.csv").read_bytes()
    other = tsr("replay", folder / "run", "--set", "birth_score=99")
    assert other.returncode == 0, other.stderr
    assert "Lost: track 1, track 2" in other.stdout


def test_a_second_track_resumes(drive: Path, tracked: tuple[Path, CommandResult]) -> None:
    folder, _ = tracked
    again = tsr("track", drive, "--evidence", folder / "run", "--set", "tau=3", "--json")
    assert json.loads(again.stdout)["resumed_at"] == FRAMES
    shown = tsr("track", drive, "--evidence", folder / "run", "--set", "tau=3")
    assert "all of it from the evidence" in shown.stdout
    assert "frames/s" not in shown.stdout


def test_ctrl_c_keeps_what_was_computed(drive: Path, tmp_path: Path) -> None:
    command = [sys.executable, TOY_CLI, "--delay", "0.1", "track", drive, "--csv", tmp_path / "rows.csv"]
    command += ["--evidence", tmp_path / "run", "--video", tmp_path / "seen.mp4"]
    worker = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        _wait_for(tmp_path / "run")
        time.sleep(1.0)
        worker.send_signal(signal.SIGINT)
        out, err = worker.communicate(timeout=60)
    finally:
        worker.kill()
    assert worker.returncode == 130, err
    assert "Traceback" not in err
    assert err.count("\n") == 1
    assert "Interrupted. Results up to frame " in err
    with EvidenceReader(tmp_path / "run") as reader:
        assert reader.state == "interrupted"
        done = len(reader)
        rows = [row.line() for row in reader.result_rows()]
    assert 0 < done < FRAMES
    assert (tmp_path / "rows.csv").read_text().splitlines()[1:] == rows
    assert (tmp_path / "seen.mp4").stat().st_size > 0
    assert "frames of 320x240" in out
    finish = tsr("track", drive, "--csv", tmp_path / "rows.csv", "--evidence", tmp_path / "run", "--json")
    assert json.loads(finish.stdout)["resumed_at"] == done


def test_a_second_ctrl_c_keeps_what_was_computed_too(drive: Path, tmp_path: Path) -> None:
    command = [sys.executable, TOY_CLI, "--delay", "0.5", "track", drive, "--csv", tmp_path / "rows.csv"]
    command += ["--evidence", tmp_path / "run", "--video", tmp_path / "seen.mp4", "--frames", "20:"]
    worker = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        _wait_for(tmp_path / "run")
        time.sleep(2.5)
        for _ in range(2):
            worker.send_signal(signal.SIGINT)
            time.sleep(0.05)
        out, err = worker.communicate(timeout=60)
    finally:
        worker.kill()
    assert (worker.returncode, out) == (130, ""), err
    assert err.count("\n") == 1
    assert f"kept in {tmp_path / 'rows.csv'} and {tmp_path / 'run'} and {tmp_path / 'seen.mp4'}. Run the same" in err
    with EvidenceReader(tmp_path / "run") as reader:
        assert reader.state == "interrupted"
        rows = [row.line() for row in reader.result_rows()]
    assert (tmp_path / "rows.csv").read_text().splitlines()[1:] == rows
    with open_video(tmp_path / "seen.mp4") as seen:
        assert len(seen.confirm()) > 0


def _wait_for(folder: Path) -> None:
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        try:
            with EvidenceReader(folder):
                return
        except EvidenceError:
            time.sleep(0.05)
    pytest.fail("the run did not start")


def test_broken_pipe_is_quiet(drive: Path) -> None:
    command = f'"{sys.executable}" -m tsr_engine params | head -n 1'
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0
    assert done.stderr == ""
    assert len(done.stdout.splitlines()) == 1


@pytest.mark.parametrize("words", ["params", "params --json", "--help"])
def test_a_closed_pipe_has_its_exit_code(words: str) -> None:
    """Exit code 141, as of a process killed by SIGPIPE, for tables, plain text and the parser's help."""
    command = f'"{sys.executable}" -m tsr_engine {words} | true; echo ${{PIPESTATUS[0]}}'
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False, timeout=60)
    assert (done.stdout, done.stderr) == ("141\n", "")


@pytest.mark.parametrize("closed", ["1>&-", "2>&-", "1>&- 2>&-"])
def test_closed_streams_do_not_lose_results(closed: str, drive: Path, tmp_path: Path) -> None:
    command = f'"{sys.executable}" "{TOY_CLI}" track "{drive}" --frames :20 --csv "{tmp_path}/rows.csv"'
    command += f' --evidence "{tmp_path}/run"'
    done = subprocess.run(["bash", "-c", f"{command} {closed}"], capture_output=True, check=False, timeout=60)
    assert done.returncode == 0
    assert len((tmp_path / "rows.csv").read_text().splitlines()) > 1
    with EvidenceReader(tmp_path / "run") as reader:
        assert reader.state == "complete"


@pytest.mark.parametrize("words", ["params", "params --json", "--help"])
def test_a_full_disk_behind_stdout(words: str) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "tsr_engine", *words.split()],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert_one_sentence(CommandResult(done.returncode, "", done.stderr), 6, "disk is full", "stdout")


def test_evidence_of_another_video(drive: Path, tracked: tuple[Path, CommandResult], tmp_path: Path) -> None:
    other = tmp_path / "other.mp4"
    other.write_bytes(drive.read_bytes() + b"\0" * 8)
    done = tsr("track", other, "--evidence", tracked[0] / "run", "--set", "tau=3")
    assert_one_sentence(done, 5, "belongs to another run", "drive.mp4 against other.mp4")


def test_the_video_is_never_overwritten(drive: Path) -> None:
    before = drive.read_bytes()
    done = tsr("track", drive, "--video", drive.parent / "." / "drive.mp4")
    assert_one_sentence(done, 2, "is the input itself")
    assert drive.read_bytes() == before


def test_a_full_disk_is_reported(drive: Path, tmp_path: Path) -> None:
    """A limit on file sizes ends the run like a full disk, with another message."""
    command = (
        f'ulimit -f 150; trap "" XFSZ; exec "{sys.executable}" "{TOY_CLI}" track "{drive}" --evidence "{tmp_path}/run"'
    )
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")} if "NUMBA_CACHE_DIR" in os.environ else None
    done = subprocess.run(
        ["bash", "-c", command], capture_output=True, text=True, check=False, timeout=120, env=environment
    )
    assert_one_sentence(CommandResult(done.returncode, done.stdout, done.stderr), 6, "Raise the limit on files")
    with EvidenceReader(tmp_path / "run") as reader:
        assert reader.state in ("failed", "interrupted")
        assert len(reader) < FRAMES
        assert sum(1 for _ in reader.frames()) == len(reader)


def test_an_unwritable_output_is_refused(drive: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    done = tsr("track", drive, "--csv", tmp_path / "file" / "rows.csv")
    assert_one_sentence(done, 6, "Cannot write")
