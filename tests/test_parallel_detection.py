"""Detection on several cores: order, number of frames in flight, failures, and equal runs."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from sample_videos import SHIPPED
from tests import toy_pipeline
from tests.test_pipeline_run import assert_same_run
from tests.waiting import wait_until
from tsr_engine.evidence import EvidenceReader
from tsr_engine.io.cores import usable_cores
from tsr_engine.params import Params
from tsr_engine.pipeline import Detected, detect_in_parallel, load_components
from tsr_engine.pipeline.detection_process import Detect
from tsr_engine.records import Detections, Picture
from tsr_engine.runs.replay import ReplayReport, replay
from tsr_engine.runs.track_video import RunRequest, track_video

FRAMES = 40


@dataclass(frozen=True)
class NumberedFrame:
    """A frame with only its number."""

    ordinal: int

    @property
    def picture(self) -> Picture:
        return np.full((2, 3, 3), self.ordinal, np.uint8)


def numbered(count: int, taken: list[int]) -> Iterator[tuple[NumberedFrame, float]]:
    for k in range(count):
        taken.append(k)
        yield NumberedFrame(k), float(k)


def trace_process(ordinal: int, picture: Picture) -> Detections:
    """Detections with the frame's ordinal as raw score and the process id as score; even frames take longer."""
    time.sleep(0.01 if ordinal % 2 == 0 else 0)
    assert (picture == ordinal).all()
    return Detections(
        np.array([[0.0, 0.0, 1.0, 1.0]]), np.array([float(ordinal)]), *np.full((2, 1), float(os.getpid()))
    )


def detectors(rows: Iterable[tuple[NumberedFrame, float, Detected | None]]) -> list[int]:
    """Ids of the processes that detected; checks that all frames came in order with their own detections."""
    found = []
    for index, (frame, number, detected) in enumerate(rows):
        assert detected is not None
        assert frame.ordinal == index == number == detected[0].raw_scores[0]
        assert detected[1] >= 0
        found.append(int(detected[0].scores[0]))
    assert len(found) == FRAMES
    return found


def detect_in_processes(detect: Detect) -> Detect:
    """Detect in other processes in one way, and here in the usual one."""
    here = os.getpid()
    return lambda ordinal, picture: (trace_process if os.getpid() == here else detect)(ordinal, picture)


def has_ended(process: int) -> bool:
    """Whether a process has ended, zombies included."""
    try:
        return Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


@pytest.mark.parametrize("cores", [1, 2, 5])
def test_frames_come_in_order_with_their_own_detections(cores: int) -> None:
    taken: list[int] = []
    most = 0

    def looked_at() -> Iterator[tuple[NumberedFrame, float, Detected | None]]:
        nonlocal most
        for index, row in enumerate(detect_in_parallel(numbered(FRAMES, taken), trace_process, cores)):
            most = max(most, len(taken) - index)
            yield row

    processes = detectors(looked_at())
    assert processes[0] == os.getpid()
    assert 2 <= len(set(processes)) <= cores or cores == 1
    assert all(has_ended(process) for process in set(processes) - {os.getpid()})
    assert taken == list(range(FRAMES))
    assert most <= (1 if cores == 1 else 4 * cores)


def test_unrequested_frames_are_not_detected() -> None:
    def detect(ordinal: int, picture: Picture) -> Detections:
        assert ordinal >= 5
        return trace_process(ordinal, picture)

    rows = list(detect_in_parallel(numbered(8, []), detect, 2, lambda frame: frame.ordinal >= 5))
    assert [row[2] is None for row in rows] == [True] * 5 + [False] * 3


@pytest.mark.parametrize("cores", [1, 3])
def test_a_failure_comes_after_the_frames_before_it(cores: int) -> None:
    def detect(ordinal: int, picture: Picture) -> Detections:
        if ordinal == 7:
            raise ValueError("seven")
        return trace_process(ordinal, picture)

    def cut() -> Iterator[tuple[NumberedFrame, float]]:
        yield from numbered(7, [])
        raise ValueError("the file ends in a frame")

    for frames, failing, message in ((numbered(FRAMES, []), detect, "seven"), (cut(), trace_process, "the file ends")):
        done = []
        with pytest.raises(ValueError, match=message):
            done.extend(frame.ordinal for frame, _, _ in detect_in_parallel(frames, failing, cores))
        assert done == list(range(7))


def kill_once(ordinal: int, picture: Picture) -> Detections:
    if ordinal > 9:
        os.kill(os.getpid(), signal.SIGKILL)
    return trace_process(ordinal, picture)


def short_of_memory(ordinal: int, picture: Picture) -> Detections:
    if ordinal > 9:
        raise MemoryError
    return trace_process(ordinal, picture)


@pytest.mark.parametrize("trouble", [kill_once, short_of_memory])
def test_frames_that_a_process_cannot_detect_are_detected_in_the_parent(trouble: Detect) -> None:
    processes = detectors(detect_in_parallel(numbered(FRAMES, []), detect_in_processes(trouble), 3))
    assert len(set(processes[:10])) > 1
    assert set(processes[10:]) == {os.getpid()}


def test_signals_for_the_whole_group_do_not_end_a_helper() -> None:
    def detect(ordinal: int, picture: Picture) -> Detections:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGTERM)
        return trace_process(ordinal, picture)

    assert len(set(detectors(detect_in_parallel(numbered(FRAMES, []), detect_in_processes(detect), 2)))) == 2


ENDLESS = """
import os, sys, time
from tests.test_parallel_detection import detect_in_parallel, numbered, trace_process
for _, _, (found, _) in detect_in_parallel(numbered(250, []), trace_process, 2):
    print(int(found.scores[0]), flush=True)
    time.sleep(0.01)
"""


def test_a_helper_ends_with_its_parent() -> None:
    with subprocess.Popen([sys.executable, "-c", ENDLESS], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        helper = next(number for line in process.stdout if (number := int(line)) != process.pid)
        assert not has_ended(helper)
        process.kill()
        process.stdout.read()  # ends at once: the helper does not inherit the parent's pipe
        wait_until(lambda: has_ended(helper))


def test_the_number_of_cores_is_checked() -> None:
    assert usable_cores() >= 1
    with pytest.raises(ValueError, match="at least 1"):
        next(detect_in_parallel(numbered(1, []), trace_process, 0))


def test_a_run_on_several_cores_stores_the_same(tmp_path: Path) -> None:
    drive = toy_pipeline.write_drive(tmp_path / "drive.mp4", 60)
    one = RunRequest(drive, toy_pipeline.PARAMS, tmp_path / "one", tmp_path / "one.csv")
    many = replace(one, evidence=tmp_path / "many", csv=tmp_path / "many.csv", cores=3)
    for request in (one, many):
        track_video(request, toy_pipeline.components())
    assert_same_run(tmp_path / "one", tmp_path / "many")
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "many.csv").read_bytes()


def test_a_run_on_several_cores_resumes_after_a_stop(tmp_path: Path) -> None:
    drive = toy_pipeline.write_drive(tmp_path / "drive.mp4", 60)
    whole = RunRequest(drive, toy_pipeline.PARAMS, tmp_path / "whole")
    track_video(whole, toy_pipeline.components())
    asked = 0

    def stop() -> bool:
        nonlocal asked
        asked += 1
        return asked > 31

    parts = replace(whole, evidence=tmp_path / "parts", cores=2)
    assert track_video(parts, toy_pipeline.components(), stop=stop).interrupted
    report = track_video(parts, toy_pipeline.components())
    assert report.resumed_at is not None
    assert report.computed < 60
    assert_same_run(tmp_path / "whole", tmp_path / "parts")


@pytest.mark.parametrize("preset", ["default", "realtime"])
def test_the_shipped_models_find_the_same_on_several_cores(preset: str, tmp_path: Path) -> None:
    params = Params.preset(preset).with_settings([("coast_foe_y", 0.5)])
    parts = load_components(params)
    for cores in (1, 3):
        request = RunRequest(SHIPPED[0].video, params, tmp_path / str(cores), stop=24, cores=cores)
        track_video(request, parts)
    assert_same_run(tmp_path / "1", tmp_path / "3")
    with EvidenceReader(tmp_path / "3") as reader:
        assert sum(len(frame.detections) for frame in reader.frames()) > 0


def test_a_scan_in_bands_resumes_and_replays_equal(tmp_path: Path) -> None:
    params = Params.preset("realtime").with_settings([("coast_foe_y", 0.5)])
    parts, asked = load_components(params), 0

    def stop() -> bool:
        nonlocal asked
        asked += 1
        return asked > 19

    whole = RunRequest(SHIPPED[0].video, params, tmp_path / "whole", start=1, stop=25)
    track_video(whole, parts)
    halved = replace(whole, evidence=tmp_path / "halved")
    assert track_video(halved, parts, stop=stop).interrupted
    track_video(halved, parts)
    assert_same_run(tmp_path / "whole", tmp_path / "halved")
    report = ReplayReport()
    frames = list(replay(tmp_path / "whole", params, parts, report=report))
    assert any(frame.tracks for frame in frames)
    assert report.identical == len(frames) == 24
