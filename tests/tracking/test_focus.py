"""The height of a camera's focus of expansion, from synthetic flow and from drives with a known camera."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from tsr_engine.errors import VideoError
from tsr_engine.io.video import VideoLimits
from tsr_engine.records import FloatArray
from tsr_engine.runs.calibration import calibrate
from tsr_engine.tracking.focus_of_expansion import find_focus

CLIPS = Path(__file__).parents[2] / "sample_videos" / "clips"
WIDTH, HEIGHT = 320.0, 180.0


def drive(
    y: float,
    pairs: int = 60,
    *,
    growth: float = 0.02,
    nod: float = 0.0,
    turn: float = 0.0,
    x: float = 0.5,
    seed: int = 4,
) -> list[tuple[FloatArray, FloatArray]]:
    """Flow of points at many depths about a focus at this share of the height; the car rotates by so many px."""
    rng = np.random.default_rng(seed)
    focus = np.array([0.5 * WIDTH, y * HEIGHT])
    pitch = rng.normal(0.0, nod, pairs + 1)
    flows = []
    for k in range(pairs):
        points = rng.uniform([0.0, 0.0], [WIDTH, HEIGHT], (80, 2))
        near = rng.uniform(0.5, 1.5, (80, 1))
        flow = growth * near * (points - focus) + [turn, pitch[k + 1] - pitch[k]] + rng.normal(0.0, 0.05, (80, 2))
        flows.append((points, flow))
    return flows


@pytest.mark.parametrize("y", [0.35, 0.5, 0.68])
@pytest.mark.parametrize(("nod", "turn"), [(0.0, 0.0), (2.0, 0.0), (1.0, 3.0)])
def test_the_focus_is_found_despite_rotation(y: float, nod: float, turn: float) -> None:
    found = find_focus(drive(y, nod=nod, turn=turn), WIDTH, HEIGHT)
    assert found is not None
    assert found.y == pytest.approx(y, abs=0.02)
    assert abs(found.y - y) < 4 * max(found.error, 0.004)
    assert found.frames == 60
    assert found.approach == pytest.approx(60 * 0.02, rel=0.3)


def test_a_longer_drive_reduces_the_uncertainty() -> None:
    short, long = (find_focus(drive(0.6, n, nod=1.0), WIDTH, HEIGHT) for n in (20, 180))
    assert short is not None
    assert long is not None
    assert long.error < 0.5 * short.error


@pytest.mark.parametrize(
    "flows", [[], drive(0.6, growth=0.0, nod=0.5), drive(0.6, 3), drive(0.6, growth=-0.02)],
    ids=["nothing", "stands", "three frames", "backs"],
)  # fmt: skip
def test_without_forward_motion_there_is_no_estimate(flows: list[tuple[FloatArray, FloatArray]]) -> None:
    assert find_focus(flows, WIDTH, HEIGHT) is None


@pytest.mark.parametrize("name", ["country_road", "low_sun"])
def test_the_focus_of_the_sample_drives(name: str) -> None:
    facts = json.loads((CLIPS / f"{name}.json").read_text())
    focal, height = facts["camera"]["focal_px"], facts["height"]
    # The optical axis meets the picture at 0.46 of its height; the camera looks down by 0.012 rad.
    truth = 0.46 - focal * math.tan(0.012) / height
    found = calibrate(CLIPS / f"{name}.mp4", stop=150)
    assert found is not None
    assert found.y == pytest.approx(truth, abs=0.02)


def test_a_standing_car_gives_no_estimate(tmp_path: Path) -> None:
    import cv2

    path = tmp_path / "stands.mp4"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 25, (320, 180))
    scene = np.random.default_rng(0).integers(0, 255, (180, 320, 3), np.uint8)
    for _ in range(10):
        writer.write(scene)
    writer.release()
    assert calibrate(path) is None


def test_the_estimate_uses_the_limits_of_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Given limits replace the default ones."""
    monkeypatch.setattr("tsr_engine.io.video.VideoLimits", lambda: VideoLimits(max_pixels=1))
    path = CLIPS / "country_road.mp4"
    assert calibrate(path, stop=60, limits=VideoLimits()) is not None
    with pytest.raises(VideoError, match="more than the limit of 1000 pixels"):
        calibrate(path, stop=60, limits=VideoLimits(max_pixels=1000))
