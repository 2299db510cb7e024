"""Contenders in turn, looped drives, notes of long runs, and growth."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.experiment import Result, machine
from benchmarks.experiments import scale, yolo_time
from benchmarks.timing.alternating import Turns, scenes_in_turn
from benchmarks.timing.growth import exponent
from benchmarks.timing.long_run import NOTES, STEP, DetectedFrame, detect_once, note_writer, repeated
from benchmarks.timing.looped_video import RATE, SIZE, base_clip, repeat_clip
from benchmarks.timing.run_notes import read_sections
from tests import toy_pipeline
from tsr_engine.evidence import EvidenceReader, VideoIdentity
from tsr_engine.io.video import open_video


def test_all_contenders_get_all_pictures_in_rotating_order() -> None:
    calls: list[tuple[str, int]] = []
    pictures = [np.full((2, 2, 3), k, np.uint8) for k in range(3)]

    def contender(name: str):
        return lambda picture: calls.append((name, int(picture[0, 0, 0])))

    turns = scenes_in_turn({name: contender(name) for name in "ab"}, pictures)
    assert calls[:2] == [("a", 0), ("b", 0)]  # not timed
    assert calls[2:] == [("a", 0), ("b", 0), ("b", 1), ("a", 1), ("a", 2), ("b", 2)]
    assert [turns.summary(name)["turns"] for name in turns.names] == [3, 3]


def test_the_fastest_of_several_turns_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    seconds = iter([5.0, 1.0, 3.0, 2.0, 4.0, 6.0])
    monkeypatch.setattr("benchmarks.timing.alternating.thread_seconds", lambda work, picture: next(seconds))
    pictures = [np.zeros((2, 2, 3), np.uint8)]
    turns = scenes_in_turn({"a": lambda _: None, "b": lambda _: None}, pictures, rounds=3)
    # turn by turn: a 5 b 1, b 3 a 2, a 4 b 6
    assert (turns.ms["a"], turns.ms["b"]) == ([2000.0], [1000.0])


def test_ratios_are_computed_per_picture() -> None:
    turns = Turns({"a": [1.0, 2.0, 30.0], "b": [2.0, 4.0, 60.0]})
    assert turns.paired("a", "b") == {"median": 0.5, "low": 0.5, "high": 0.5}
    assert turns.median("a") == 2.0


def test_a_looped_drive_shows_the_same_pictures_again(tmp_path: Path) -> None:
    base = base_clip(tmp_path, 6, drives=2)
    assert base_clip(tmp_path, 6, drives=2) == base
    drive = tmp_path / "drive.mp4"
    repeat_clip(base, drive, 18)
    with open_video(drive) as video:
        assert len(video.table) == 18
        assert float(video.table.interval()) == pytest.approx(1 / RATE)
        frames = [(frame.seconds, frame.picture) for frame in video.frames(0, None)]
    np.testing.assert_allclose([s for s, _ in frames], np.arange(18) / RATE, atol=1e-4)
    assert frames[0][1].shape == (SIZE[1], SIZE[0], 3)
    for k in range(12):
        np.testing.assert_array_equal(frames[k][1], frames[k + 6][1])


def test_more_frames_than_the_drives_have_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("benchmarks.timing.looped_video.SHIPPED", ())
    with pytest.raises(ValueError, match="Got 5"):
        base_clip(tmp_path, 5)
    assert not list(tmp_path.iterdir())


def test_a_long_run_resumes_after_a_stop(tmp_path: Path) -> None:
    components = toy_pipeline.components()
    pictures = [toy_pipeline.drive_picture(k) for k in range(20)]
    clip = [DetectedFrame(picture, components.detector.detect(picture), (0.0, 0.0)) for picture in pictures]
    identity = VideoIdentity("toy.mp4", "0" * 64, 1)

    def go(folder: Path, last: int) -> int:
        return repeated(clip, components, toy_pipeline.PARAMS, identity, folder, 30, lambda done: done < last)

    assert go(tmp_path / "parts", 12) == 12
    assert go(tmp_path / "parts", 30) == 30
    assert go(tmp_path / "whole", 30) == 30
    with EvidenceReader(tmp_path / "parts") as parts, EvidenceReader(tmp_path / "whole") as whole:
        assert len(parts) == len(whole) == 30
        for a, b in zip(parts.frames(), whole.frames(), strict=True):
            assert [t.track_id for t in a.tracks] == [t.track_id for t in b.tracks]
            np.testing.assert_array_equal([t.box for t in a.tracks], [t.box for t in b.tracks])
        assert any(frame.tracks for frame in whole.frames())
        # from the second turn on the signs are withheld
        assert all(not len(frame.detections.boxes) for frame in whole.frames(20, 30))


def test_stored_detections_are_reused(tmp_path: Path) -> None:
    video = toy_pipeline.write_drive(tmp_path / "toy.mp4", 8)
    components = toy_pipeline.components()
    first = detect_once(video, components, toy_pipeline.PARAMS, tmp_path / "seen.json")
    calls = components.detector.calls
    again = detect_once(video, components, toy_pipeline.PARAMS, tmp_path / "seen.json")
    assert components.detector.calls == calls == 8
    assert sum(len(seen.detections.boxes) for seen in first) > 0
    for a, b in zip(first, again, strict=True):
        assert a.shift == b.shift
        for name in ("boxes", "raw_scores", "prior", "scores"):
            one, other = getattr(a.detections, name), getattr(b.detections, name)
            assert one.shape == other.shape
            np.testing.assert_array_equal(one, other)
    detect_once(video, components, toy_pipeline.PARAMS.with_settings([("tau", 9.0)]), tmp_path / "seen.json")
    assert components.detector.calls == 16


def _notes(path: Path, *processes: list[tuple[int, float]]) -> Path:
    """Notes of each process, (frames, wall seconds), with 4 ms of CPU a frame and memory of 100 MB plus 1 MB a note."""
    lines = []
    for notes in processes:
        lines.append({"held_mb": 50.0})
        first = notes[0][0]
        for number, (frames, wall) in enumerate(notes):
            peak = 150.0 + number
            lines.append({"frames": frames, "wall": wall, "cpu": 0.004 * (frames - first), "peak_mb": peak})
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    return path


def test_sections_omit_time_between_processes(tmp_path: Path) -> None:
    path = _notes(tmp_path / NOTES, [(250, 5.0), (500, 10.0), (750, 15.0)], [(1000, 900.0), (1250, 901.0)])
    first, second = read_sections(path, (750, 1250))
    assert (first.frames, first.per_second, first.sittings) == (750, 50.0, 1)
    assert (second.frames, second.per_second, second.sittings) == (1250, 250.0, 2)
    assert first.cpu_ms == pytest.approx(4.0)
    assert first.peak_mb == 102.0
    assert [s.frames for s in read_sections(path, (500, 100_000))] == [500, 1250]
    assert read_sections(tmp_path / "nowhere", (500,)) == []


def test_notes_are_written_and_time_ends(tmp_path: Path) -> None:
    with (tmp_path / NOTES).open("w", encoding="utf-8") as lines:
        assert note_writer(lines, 3600.0)(STEP)
        assert note_writer(lines, 3600.0)(STEP + 1)
        assert not note_writer(lines, -1.0)(2 * STEP)
    notes = [json.loads(line) for line in (tmp_path / NOTES).read_text().splitlines()]
    assert [note["frames"] for note in notes] == [STEP, 2 * STEP]
    assert all(0 < note["rss_mb"] <= note["peak_mb"] for note in notes)


def test_exponents_are_those_of_power_laws() -> None:
    assert exponent([1, 2, 4, 8], [3, 12, 48, 192]) == pytest.approx(2.0)
    assert exponent([1, 10], [5, 5]) == pytest.approx(0.0)


def _section(frames: int, mb: float) -> dict[str, float]:
    return {"frames": frames, "per_second": 10.0, "cpu_ms": 80.0, "peak_mb": mb, "sittings": 1}


@pytest.mark.parametrize("sections", [[], [_section(1500, 400.0)], [_section(1500, 400.0), _section(132_400, 412.0)]])
def test_the_text_about_scale_states_the_reached_length(sections: list[dict[str, float]], tmp_path: Path) -> None:
    figures = {
        "real": [], "repeated": sections, "real_evidence_mb": 1.0, "repeated_evidence_mb": 2.0,
        "signs": {"1": 5.0, "16": 80.0, "2": 10.0}, "signs_exponent": 1.0, "sizes": {"360x288": 20.0, "720x576": 60.0},
        "sizes_exponent": 0.79,
    }  # fmt: skip
    result = Result("scale", "", figures, {}, machine())
    text = scale.EXPERIMENT.report(result)
    assert "Everything: **not measured yet**" in text
    assert "| signs in view | 1 | 2 | 16 |" in text
    assert ("the peak memory rises by 12 MB" in text) == (len(sections) == 2)
    assert ("time ran out at frame 1,500" in text) == (len(sections) == 1)
    if not sections:
        assert scale.EXPERIMENT.plot is not None
        scale.EXPERIMENT.plot(result, tmp_path / "scale.svg")
        assert (tmp_path / "scale.svg").stat().st_size > 1000


def test_targets_are_judged() -> None:
    assert yolo_time.verdict(0.2, 0.5, 0.25).endswith("(aim met)")
    assert "bar met, aim not" in yolo_time.verdict(0.4, 0.5, 0.25)
    assert "**bar missed**" in yolo_time.verdict(0.51, 0.5, 0.25)
