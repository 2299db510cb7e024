"""Live runs of the toy drive: outputs, resuming after a kill, interruption, failures."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import av
import pytest

from tests import toy_pipeline
from tsr_engine.errors import EvidenceError, StorageError, VideoError
from tsr_engine.evidence import EvidenceReader, differences
from tsr_engine.io.video import open_video
from tsr_engine.io.video_cursor import Cursor
from tsr_engine.runs.track_video import Progress, RunReport, RunRequest, track_video

SCRIPT = Path(__file__).with_name("toy_pipeline.py")
FRAMES = 100


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return toy_pipeline.write_drive(tmp_path_factory.mktemp("drive") / "drive.mp4", FRAMES)


@pytest.fixture(scope="module")
def finished(drive: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, RunReport]:
    """An uninterrupted run with all outputs."""
    folder = tmp_path_factory.mktemp("finished")
    request = RunRequest(drive, toy_pipeline.PARAMS, folder / "run", folder / "rows.csv", folder / "seen.mp4")
    return folder, track_video(request, toy_pipeline.components())


def assert_same_run(a: Path, b: Path) -> None:
    with EvidenceReader(a) as first, EvidenceReader(b) as second:
        assert len(first) == len(second)
        for x, y in zip(first.frames(), second.frames(), strict=True):
            assert list(differences(x, y, ignore=frozenset({"timings"}))) == [], f"frame {x.ordinal}"
        assert list(first.frame_table()) == list(second.frame_table())
        assert list(first.result_rows()) == list(second.result_rows())


def test_a_run_finds_the_signs_and_writes_everything(finished: tuple[Path, RunReport]) -> None:
    folder, report = finished
    assert (report.frames, report.interrupted, report.resumed_at) == (FRAMES, False, None)
    assert len(report.tracks) == 3
    assert report.tracks[0].first_frame == 4
    sources = {source for track in report.tracks for source in track.frames}
    assert {"detected", "relocalised"} <= sources
    assert {"decode", "detect", "shift", "gate", "relocalise", "classify", "fuse", "evidence"} <= set(report.stages)
    with EvidenceReader(folder / "run") as reader:
        assert reader.state == "complete"
        assert len(reader) == FRAMES
        lines = [row.line() for row in reader.result_rows()]
    written = (folder / "rows.csv").read_text().splitlines()
    assert written[0] == "frame,track_id,x1,y1,x2,y2,class_id,score,source"
    assert written[1:] == lines
    with open_video(folder / "seen.mp4") as seen:
        assert len(seen.confirm()) == FRAMES
    assert not [path for path in folder.rglob("*") if ".part" in path.name]


def test_boxes_follow_the_drawn_sign(finished: tuple[Path, RunReport]) -> None:
    from tsr_engine.geometry.boxes import iou

    folder, _ = finished
    with EvidenceReader(folder / "run") as reader:
        overlaps = [
            float(iou(track.box, toy_pipeline.sign_box(frame.ordinal % 40))[0, 0])
            for frame in reader.frames(pixels=False)
            for track in frame.tracks
            if track.state == "confirmed"
            and track.source == "detected"
            and toy_pipeline.sign_box(frame.ordinal % 40) is not None
        ]
    assert len(overlaps) > 40
    assert sorted(overlaps)[len(overlaps) // 2] > 0.7


def test_events_have_sentences_and_values(finished: tuple[Path, RunReport]) -> None:
    folder, _ = finished
    with EvidenceReader(folder / "run") as reader:
        events = [event for _, event in reader.events()]
    found = [event for event in events if event.kind in ("rejected", "relocalised")]
    rejections = [event for event in found if "l_positive" in event.values]
    assert rejections
    assert all("no detection for" in event.text for event in found if "undetected" in event.values)
    assert all("l_positive" in event.values or "undetected" in event.values for event in found)
    assert all(event.text.endswith(".") for event in found)
    for event in rejections:
        assert event.values["l_positive"] >= event.values["tau"] == 3.0
        assert f"L = {event.values['l_positive']:.1f}" in event.text


def test_frame_range_keeps_the_ordinals_of_the_video(drive: Path, tmp_path: Path) -> None:
    request = RunRequest(drive, toy_pipeline.PARAMS, tmp_path / "run", tmp_path / "rows.csv", start=40, stop=60)
    report = track_video(request, toy_pipeline.components())
    assert report.frames == 20
    frames = {int(line.split(",")[0]) for line in (tmp_path / "rows.csv").read_text().splitlines()[1:]}
    assert min(frames) >= 44
    assert max(frames) == 59


def test_a_repeatedly_stopped_run_equals_an_uninterrupted_one(
    drive: Path, finished: tuple[Path, RunReport], tmp_path: Path
) -> None:
    folder, whole = finished
    rounds = 0
    while True:
        rounds += 1
        count = 0

        def stop() -> bool:
            nonlocal count
            count += 1
            return count > 38  # called once before the first frame

        request = RunRequest(drive, toy_pipeline.PARAMS, tmp_path / "run", tmp_path / "rows.csv", tmp_path / "seen.mp4")
        report = track_video(request, toy_pipeline.components(), stop=stop if rounds == 1 else None)
        if rounds == 1:
            assert report.interrupted
            assert report.frames == 37
            with EvidenceReader(tmp_path / "run") as reader:
                assert reader.state == "interrupted"
                assert len(reader) == 37
            assert len((tmp_path / "rows.csv").read_text().splitlines()) > 20
        if not report.interrupted:
            break
    assert rounds == 2
    assert report.resumed_at == 37
    assert [t.track_id for t in report.tracks] == [t.track_id for t in whole.tracks]
    assert_same_run(tmp_path / "run", folder / "run")
    assert (tmp_path / "rows.csv").read_bytes() == (folder / "rows.csv").read_bytes()
    assert (tmp_path / "seen.mp4").read_bytes() == (folder / "seen.mp4").read_bytes()


def test_a_run_resumed_after_kill_9_equals_an_uninterrupted_one(
    drive: Path, finished: tuple[Path, RunReport], tmp_path: Path
) -> None:
    environment = os.environ | {"NUMBA_NUM_THREADS": "1"}
    worker = subprocess.Popen([sys.executable, SCRIPT, drive, tmp_path / "run", "0.03"], env=environment)
    try:
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline:
            time.sleep(0.02)
            try:
                with EvidenceReader(tmp_path / "run") as reader:
                    if len(reader) >= 32:
                        break
            except EvidenceError:
                continue
        worker.send_signal(signal.SIGKILL)
    finally:
        worker.kill()
        worker.wait()
    with EvidenceReader(tmp_path / "run") as reader:
        stored = len(reader)
        assert reader.state == "interrupted"
    assert 32 <= stored < FRAMES
    parts = toy_pipeline.components()
    report = track_video(RunRequest(drive, toy_pipeline.PARAMS, tmp_path / "run"), parts)
    assert report.resumed_at == stored
    assert parts.detector.calls == FRAMES - stored
    assert_same_run(tmp_path / "run", finished[0] / "run")


@pytest.fixture
def steps(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Frames after which a decoder made a step."""
    found: list[int] = []
    step = Cursor.step

    def counted(cursor: Cursor) -> object:
        found.append(cursor.position)
        return step(cursor)

    monkeypatch.setattr(Cursor, "step", counted)
    return found


def write_avi(path: Path) -> Path:
    """The toy drive in a file without presentation times."""
    with av.open(path, "w") as out:
        stream = out.add_stream("mjpeg", rate=toy_pipeline.FPS, options={"qscale": "2"})
        stream.width, stream.height, stream.pix_fmt = toy_pipeline.WIDTH, toy_pipeline.HEIGHT, "yuvj420p"
        for k in range(FRAMES):
            out.mux(stream.encode(av.VideoFrame.from_ndarray(toy_pipeline.drive_picture(k), format="bgr24")))
        out.mux(stream.encode())
    return path


@pytest.mark.parametrize("timed", [True, False])
def test_resuming_does_not_decode_from_the_start(timed: bool, tmp_path: Path, steps: list[int]) -> None:
    """The evidence has the table of its frames; without presentation times (AVI), only decoding gives it."""
    video = (
        toy_pipeline.write_drive(tmp_path / "keys.mp4", FRAMES, keys=10) if timed else write_avi(tmp_path / "keys.avi")
    )
    request = RunRequest(video, toy_pipeline.PARAMS, tmp_path / "run", stop=60)
    track_video(request, toy_pipeline.components())
    steps.clear()
    report = track_video(replace(request, stop=70), toy_pipeline.components())
    assert (report.resumed_at, report.computed) == (60, 10)
    # One step opens the file. A jump to a key frame, here 50, takes none; the very first frame is decoded again.
    assert min(steps[1:]) == (50 if timed else -1)
    track_video(RunRequest(video, toy_pipeline.PARAMS, tmp_path / "whole", stop=70), toy_pipeline.components())
    assert_same_run(tmp_path / "run", tmp_path / "whole")


def test_a_start_in_the_middle_uses_the_frame_table(tmp_path: Path, steps: list[int]) -> None:
    video = toy_pipeline.write_drive(tmp_path / "keys.mp4", FRAMES, keys=10)
    with open_video(video) as file:
        table = file.confirm()
    request = RunRequest(video, toy_pipeline.PARAMS, tmp_path / "counted", start=65, stop=70)
    track_video(request, toy_pipeline.components())
    steps.clear()
    track_video(replace(request, evidence=tmp_path / "run", table=table), toy_pipeline.components())
    assert min(steps[1:]) == 60
    assert_same_run(tmp_path / "run", tmp_path / "counted")
    moved = replace(table, pts=table.pts + 1, stamps=table.stamps + 1)
    with pytest.raises(VideoError, match="does not match its frame table"):
        track_video(replace(request, evidence=tmp_path / "other", table=moved), toy_pipeline.components())


def test_a_finished_run_is_not_computed_again(drive: Path, finished: tuple[Path, RunReport], tmp_path: Path) -> None:
    folder, whole = finished
    parts = toy_pipeline.components()
    report = track_video(RunRequest(drive, toy_pipeline.PARAMS, folder / "run", tmp_path / "again.csv"), parts)
    assert parts.detector.calls == 0
    assert report.frames == whole.frames
    assert (tmp_path / "again.csv").read_bytes() == (folder / "rows.csv").read_bytes()


def test_progress_counts_to_the_end(drive: Path) -> None:
    seen: list[Progress] = []
    track_video(RunRequest(drive, toy_pipeline.PARAMS, stop=20), toy_pipeline.components(), progress=seen.append)
    assert [at.done for at in seen] == list(range(1, 21))
    assert {at.total for at in seen} == {20}
    assert (seen[0].rate, seen[0].remaining) == (None, None)  # one frame, which includes compilation, gives no rate
    assert seen[-1].remaining == 0.0
    assert seen[-1].rate is not None
    assert seen[-1].rate > 0


def test_the_first_frame_gives_no_rate() -> None:
    report = RunReport("drive.mp4", 640, 360, seconds=22.0, first_seconds=20.0, computed=41)
    assert report.rate() == 20.0
    assert report.rate(24.0) == 10.0
    assert RunReport("drive.mp4", 640, 360, seconds=22.0, first_seconds=20.0, computed=1).rate() is None


def test_evidence_of_another_video_or_parameters_is_refused(
    drive: Path, finished: tuple[Path, RunReport], tmp_path: Path
) -> None:
    folder, _ = finished
    other = toy_pipeline.write_drive(tmp_path / "other.mp4", 12)
    with pytest.raises(EvidenceError, match=r"video: drive.mp4 against other.mp4"):
        track_video(RunRequest(other, toy_pipeline.PARAMS, folder / "run"), toy_pipeline.components())
    changed = toy_pipeline.PARAMS.with_settings([("tau", 4.0)])
    with pytest.raises(EvidenceError, match="tau"):
        track_video(RunRequest(drive, changed, folder / "run"), toy_pipeline.components(changed))
    with pytest.raises(EvidenceError, match="frames from 0 on, expected from 5 on"):
        track_video(RunRequest(drive, toy_pipeline.PARAMS, folder / "run", start=5), toy_pipeline.components())
    with EvidenceReader(folder / "run") as reader:
        assert len(reader) == FRAMES


def test_a_full_disk_keeps_what_was_computed(
    drive: Path, finished: tuple[Path, RunReport], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The third commit fails: the frames of the first two stay, and the run can resume."""
    from tsr_engine.evidence.writer import EvidenceWriter

    commits = 0
    commit = EvidenceWriter.commit

    def failing(self: EvidenceWriter) -> None:
        nonlocal commits
        commits += 1
        if commits >= 3:
            raise StorageError("The disk is full.")
        commit(self)

    monkeypatch.setattr(EvidenceWriter, "commit", failing)
    request = RunRequest(drive, toy_pipeline.PARAMS, tmp_path / "run", tmp_path / "rows.csv")
    with pytest.raises(StorageError, match="disk is full"):
        track_video(request, toy_pipeline.components())
    monkeypatch.undo()
    with EvidenceReader(tmp_path / "run") as reader:
        assert len(reader) == 64
        assert reader.state != "complete"
    assert len((tmp_path / "rows.csv").read_text().splitlines()) > 30
    track_video(request, toy_pipeline.components())
    assert_same_run(tmp_path / "run", finished[0] / "run")
