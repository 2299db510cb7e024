"""Outputs of a live run that cannot be written."""

from __future__ import annotations

import errno
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests import toy_pipeline
from tsr_engine.errors import StorageError, UsageError
from tsr_engine.evidence import EvidenceReader
from tsr_engine.io.video import open_video
from tsr_engine.runs.outputs import RunOutputs
from tsr_engine.runs.track_video import RunRequest, track_video

FRAMES = 100


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return toy_pipeline.write_drive(tmp_path_factory.mktemp("drive") / "drive.mp4", FRAMES)


def test_outputs_may_not_be_the_video(drive: Path, tmp_path: Path) -> None:
    link = tmp_path / "link.mp4"
    link.symlink_to(drive)
    before = drive.read_bytes()
    for output in (drive, link):
        with pytest.raises(UsageError, match="is the input itself"):
            track_video(RunRequest(drive, toy_pipeline.PARAMS, annotated=output), toy_pipeline.components())
    same = tmp_path / "x.mp4"
    with pytest.raises(UsageError, match="same name"):
        track_video(RunRequest(drive, toy_pipeline.PARAMS, csv=same, annotated=same), toy_pipeline.components())
    assert drive.read_bytes() == before


@pytest.mark.parametrize("name", ["seen.avi", "seen"])
def test_an_annotated_video_has_a_description(drive: Path, tmp_path: Path, name: str) -> None:
    with pytest.raises(UsageError, match=r"ends in \.mp4, got .*seen"):
        track_video(RunRequest(drive, toy_pipeline.PARAMS, annotated=tmp_path / name), toy_pipeline.components())
    assert not list(tmp_path.iterdir())


def test_a_gap_too_long_for_the_annotated_video_is_reported(
    drive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tsr_engine.io.video_writer.MAX_GAP_TICKS", 60)
    request = RunRequest(drive, toy_pipeline.PARAMS, annotated=tmp_path / "seen.mp4", stop=3)
    report = track_video(request, toy_pipeline.components())
    assert "seen.mp4 has 2 gaps in time cut" in report.warnings[-1]
    assert (tmp_path / "seen.mp4").exists()


def test_a_range_beyond_the_end_is_refused_and_leaves_nothing(drive: Path, tmp_path: Path) -> None:
    request = RunRequest(drive, toy_pipeline.PARAMS, csv=tmp_path / "rows.csv", start=5000)
    with pytest.raises(UsageError, match="frames 0 to 99"):
        track_video(request, toy_pipeline.components())
    assert not (tmp_path / "rows.csv").exists()


@pytest.mark.parametrize("fits", [0, 2])
def test_failing_rows_do_not_affect_other_outputs(
    drive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fits: int
) -> None:
    """Rows of the first track fail during the run, those of the last one at its end."""
    opened = RunOutputs.open

    class Full:
        def __init__(self) -> None:
            self.tracks: set[str] = set()

        def write(self, line: str) -> None:
            self.tracks.add(line.split(",")[1])
            if len(self.tracks) > fits:
                raise OSError(errno.ENOSPC, "No space left on device")

    def open_full(self: RunOutputs, stack: ExitStack) -> None:
        opened(self, stack)
        self._rows = Full()

    monkeypatch.setattr(RunOutputs, "open", open_full)
    request = RunRequest(drive, toy_pipeline.PARAMS, tmp_path / "run", tmp_path / "rows.csv", tmp_path / "seen.mp4")
    with pytest.raises(StorageError, match=r"rows\.csv: the disk is full"):
        track_video(request, toy_pipeline.components())
    with EvidenceReader(tmp_path / "run") as reader:
        assert reader.state == "failed"
        assert reader.header.reason.startswith(f"Cannot write {tmp_path / 'rows.csv'}: the disk is full.")
        done = len(reader)
        assert 0 < done <= FRAMES
    with open_video(tmp_path / "seen.mp4") as seen:
        assert len(seen.confirm()) in (done, done - 1)
