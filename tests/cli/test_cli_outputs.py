"""A refused command never loses files in the output or evidence folder."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.cli.test_cli_track import FRAMES, assert_one_sentence, toy_pipeline, tsr
from tsr_engine.errors import StorageError
from tsr_engine.evidence import EvidenceReader, EvidenceWriter, read_header


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path: Path = toy_pipeline.write_drive(tmp_path_factory.mktemp("outputs") / "drive.mp4", FRAMES)
    return path


@pytest.fixture
def run(drive: Path, tmp_path: Path) -> Path:
    done = tsr("track", drive, "--evidence", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    return tmp_path / "run"


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("--restart", "--csv", "folder"), 6),
        (("--restart", "--frames", f"{FRAMES + 5}:"), 2),
        (("--frames", "20:40"), 5),
        (("--frames", "0:20"), 5),
        (("--csv", "folder"), 6),
        (("--csv", "run/run.json"), 2),
        (("--restart", "--csv", "run/evidence.sqlite"), 2),
        (("--csv", "run/../same.mp4", "--video", "same.mp4"), 2),
        (("--csv", "run"), 2),
        (("--csv", "new", "--video", "new/seen.mp4"), 2),
    ],
)
def test_a_refused_command_leaves_a_complete_run_as_it_was(
    drive: Path, run: Path, words: tuple[str, ...], code: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(run.parent)
    (run.parent / "folder").mkdir()
    before = (run / "run.json").read_text()
    assert_one_sentence(tsr("track", drive, "--evidence", run, *words), code)
    assert (run / "run.json").read_text() == before
    with EvidenceReader(run) as reader:
        assert (reader.state, len(reader)) == ("complete", FRAMES)


def test_a_store_without_its_run_file_is_not_overwritten(drive: Path, run: Path) -> None:
    (run / "run.json").unlink()
    assert_one_sentence(tsr("track", drive, "--evidence", run), 5, "holds frames", "--restart")
    assert tsr("track", drive, "--evidence", run, "--restart").returncode == 0
    assert read_header(run).state == "complete"


def test_a_run_without_a_frame_is_not_replayed(drive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(self: EvidenceWriter) -> None:
        raise StorageError("The disk is full.")

    with monkeypatch.context() as patch:
        patch.setattr(EvidenceWriter, "commit", full)
        assert tsr("track", drive, "--evidence", tmp_path / "run").returncode == 6
    assert_one_sentence(tsr("replay", tmp_path / "run"), 5, "holds no frame yet")


def test_links_stay_links_and_devices_stay_devices(run: Path, tmp_path: Path) -> None:
    target, link, pipe = tmp_path / "target.csv", tmp_path / "link.csv", tmp_path / "pipe"
    target.write_text("old")
    link.symlink_to(target)
    os.mkfifo(pipe)
    os.mkfifo(tmp_path / "pipe.mp4")
    assert tsr("replay", run, "--csv", link).returncode == 0
    assert link.is_symlink()
    assert target.read_text().startswith("frame,track_id")
    assert_one_sentence(tsr("replay", run, "--csv", pipe), 6, "a device or a pipe")
    assert_one_sentence(
        tsr("track", toy_pipeline.write_drive(tmp_path / "short.mp4", 4), "--video", tmp_path / "pipe.mp4"),
        6,
        "a device or a pipe",
    )
    assert pipe.is_fifo()
    assert_one_sentence(tsr("replay", run, "--csv", target / "x.csv"), 6, "a file stands where a folder is needed")
    assert_one_sentence(tsr("replay", run, "--csv", tmp_path), 6, "Name a file.")
    loop = tmp_path / "loop.mp4"
    loop.symlink_to(loop.name)
    assert_one_sentence(tsr("replay", run, "--csv", loop), 6, "leads back to itself")
    assert_one_sentence(tsr("track", tmp_path / "short.mp4", "--video", loop), 6, "leads back to itself")
    assert_one_sentence(tsr("replay", run, "--csv", run / "run.json"), 2, "a file of the evidence itself")
