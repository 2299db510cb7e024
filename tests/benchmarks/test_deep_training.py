"""Training of the small deep detector; needs PyTorch, which the extra `bench` brings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("onnx")

from benchmarks.deep import train  # noqa: E402
from tsr_engine.io.gtsdb import Scene  # noqa: E402


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    torch.set_num_threads(1)
    monkeypatch.setattr("benchmarks.deep.crops.SIDE", 64)
    monkeypatch.setattr(train, "BATCH", 3)
    monkeypatch.setattr(train, "SIGNS", 1)


def scenes() -> tuple[list[np.ndarray], list[Scene]]:
    rng = np.random.default_rng(0)
    pictures = [rng.integers(0, 120, (400, 500, 3), dtype=np.uint8) for _ in range(2)]
    pictures[0][150:200, 200:250] = (20, 20, 240)
    boxes = np.array([[200.0, 150, 250, 200]]), np.zeros((0, 4))
    return pictures, [Scene(f"{k}.jpg", Path(), b, np.zeros(len(b), np.int64)) for k, b in enumerate(boxes)]


def steps(state: train.Training, count: int) -> None:
    pictures, known = scenes()
    for _ in range(count):
        rng = np.random.default_rng([1, state.step])
        train.advance(state, train.draw(rng, pictures, known, state.hard), train.rate_at(state.step, 10))


def test_a_stopped_training_resumes_with_the_same_result(tmp_path: Path) -> None:
    through, stopped = train.Training.start(0), train.Training.start(0)
    steps(through, 1)
    steps(stopped, 1)
    for k in range(3):  # read-only arrays of numpy
        stopped.hard.add(np.float64(-30), np.int64(0), np.float64(k), np.float64(k))
        through.hard.add(-30.0, 0, float(k), float(k))
    stopped.save(tmp_path / "state.pt", {"steps": 2})
    again = train.Training.start(5)
    again.load(tmp_path / "state.pt", {"steps": 2})
    steps(again, 1)
    steps(through, 1)
    assert again.step == 2
    assert again.hard.places == through.hard.places
    assert len(through.hard.places) > 0
    for name, value in through.average.items():
        torch.testing.assert_close(again.average[name], value)


def test_a_state_of_other_settings_is_refused(tmp_path: Path) -> None:
    train.Training.start(0).save(tmp_path / "state.pt", {"seed": 2, "steps": 5})
    train.Training.start(0).load(tmp_path / "state.pt", {"seed": 2, "steps": 9})
    with pytest.raises(SystemExit, match="expected {'seed': 3"):
        train.Training.start(0).load(tmp_path / "state.pt", {"seed": 3, "steps": 5})


def test_the_learning_rate_rises_and_falls() -> None:
    rates = [train.rate_at(step, 200) for step in range(200)]
    assert np.argmax(rates) < 20
    assert rates[0] < 0.2 * max(rates)
    assert 0 < rates[-1] < 0.01 * max(rates)
    assert max(rates) <= 1.01 * train.RATE
