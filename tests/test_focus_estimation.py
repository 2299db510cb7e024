"""Runs that estimate the camera's focus of expansion from their video.

Frames used, stored values, and interruptions.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tests import toy_pipeline
from tsr_engine.errors import EvidenceError
from tsr_engine.evidence import EvidenceReader, read_header
from tsr_engine.evidence.header import write_header
from tsr_engine.params import Params
from tsr_engine.runs import calibration
from tsr_engine.runs.calibration import calibrate, with_focus
from tsr_engine.runs.replay import run_params
from tsr_engine.runs.track_video import RunRequest, track_video
from tsr_engine.tracking.focus_of_expansion import Focus, find_focus

DRIVE = Path(__file__).parents[1] / "sample_videos" / "clips" / "low_sun.mp4"
ASKING = toy_pipeline.PARAMS.with_settings([("coast_foe_y", None)])


@pytest.fixture(scope="module")
def stands(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive in which only a sign moves."""
    return toy_pipeline.write_drive(tmp_path_factory.mktemp("stands") / "stands.mp4", 12)


def test_the_estimate_stops_at_low_uncertainty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calibration, "ESTIMATE_EVERY_FRAMES", 60)
    monkeypatch.setattr(calibration, "MAX_STANDARD_ERROR", 0.05)
    seen: list[tuple[int, int | None]] = []
    found = calibrate(DRIVE, progress=lambda done, total: seen.append((done, total)))
    assert found is not None
    assert found.error <= calibration.MAX_STANDARD_ERROR
    assert seen[-1] == (60, 300)
    assert found.frames == 59


def test_the_estimate_continues_while_uncertain_up_to_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calibration, "ESTIMATE_EVERY_FRAMES", 30)
    monkeypatch.setattr(calibration, "MAX_STANDARD_ERROR", 0.0)
    monkeypatch.setattr(calibration, "MAX_FRAMES", 90)
    found = calibrate(DRIVE)
    assert found is not None
    assert found.frames == 89


def test_a_run_keeps_its_estimated_focus(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A resumed run and a replay use the run's focus, even if a new estimate would differ."""
    request = RunRequest(DRIVE, ASKING, tmp_path / "run", stop=4)
    report = track_video(request, toy_pipeline.components(ASKING))
    assert report.focus is not None
    assert report.focus_seconds > 0.0
    monkeypatch.setattr(calibration, "find_focus", lambda *_: Focus(0.9, 0.001, 100, 1.0))
    again = track_video(replace(request, stop=8), toy_pipeline.components(ASKING))
    assert (again.resumed_at, again.frames, again.focus) == (4, 8, None)
    with EvidenceReader(tmp_path / "run") as reader:
        assert run_params(reader).tracking.coast_foe_y == round(report.focus.y, 3)
    assert track_video(replace(request, restart=True), toy_pipeline.components(ASKING)).focus == Focus(
        0.9, 0.001, 100, 1.0
    )


def test_a_run_with_a_set_focus_is_resumed_with_it(stands: Path, tmp_path: Path) -> None:
    """As with every other parameter. Runs of earlier versions do not say whether their focus was set."""
    request = RunRequest(stands, toy_pipeline.PARAMS, tmp_path / "run", stop=4)
    track_video(request, toy_pipeline.components())
    without = replace(request, params=ASKING, stop=8)
    with pytest.raises(EvidenceError, match=r"tracking\.coast_foe_y: 0\.5 against None"):
        track_video(without, toy_pipeline.components(ASKING))
    assert track_video(replace(request, stop=6), toy_pipeline.components()).resumed_at == 4
    header = read_header(tmp_path / "run")
    facts = {name: fact for name, fact in header.frame_table.items() if name != "focus_estimated"}
    write_header(tmp_path / "run", replace(header, frame_table=facts))
    assert track_video(without, toy_pipeline.components(ASKING)).resumed_at == 6


def test_a_standing_car_is_tracked(stands: Path, tmp_path: Path) -> None:
    report = track_video(RunRequest(stands, ASKING, tmp_path / "run"), toy_pipeline.components(ASKING))
    assert (report.frames, report.focus) == (12, None)
    with EvidenceReader(tmp_path / "run") as reader:
        assert run_params(reader).tracking.coast_foe_y is None


def test_a_run_reports_progress_of_the_estimate(monkeypatch: pytest.MonkeyPatch) -> None:
    """For a standing car, two minutes are read before the first frame is tracked."""
    monkeypatch.setattr(calibration, "ESTIMATE_EVERY_FRAMES", 60)
    monkeypatch.setattr(calibration, "MAX_STANDARD_ERROR", 0.05)
    reported: list[object] = []
    track_video(
        RunRequest(DRIVE, ASKING, stop=2),
        toy_pipeline.components(ASKING),
        focus_progress=lambda looked, most: reported.append((looked, most)),
        progress=lambda at: reported.append(at.done),
    )
    assert reported == [*((looked, 300) for looked in range(1, 61)), 1, 2]


def test_a_run_stopped_during_the_estimate_leaves_nothing(tmp_path: Path) -> None:
    asked = 0

    def stop() -> bool:
        nonlocal asked
        asked += 1
        return asked > 5

    request = RunRequest(DRIVE, ASKING, tmp_path / "run", tmp_path / "rows.csv")
    report = track_video(request, toy_pipeline.components(ASKING), stop=stop)
    assert report.interrupted
    assert report.frames == 0
    assert asked < 10  # it read no further frame
    assert list(tmp_path.iterdir()) == []


def test_the_estimate_uses_the_given_horizontal_focus(monkeypatch: pytest.MonkeyPatch) -> None:
    requests: list[float] = []

    def watched(flows: object, width: float, height: float, x: float = 0.5) -> Focus | None:
        requests.append(x)
        return find_focus(flows, width, height, x)  # type: ignore[arg-type]

    monkeypatch.setattr(calibration, "find_focus", watched)
    monkeypatch.setattr(calibration, "ESTIMATE_EVERY_FRAMES", 20)
    params, found = with_focus(Params().with_settings([("foe_x", 0.52)]), DRIVE)
    assert found is not None
    assert params.tracking.coast_foe_y == round(found.y, 3)
    assert set(requests) == {0.52}


def test_a_truncated_file_gives_no_estimate(tmp_path: Path) -> None:
    broken = tmp_path / "broken.mp4"
    broken.write_bytes(DRIVE.read_bytes()[:200])
    assert with_focus(Params(), broken) == (Params(), None)
