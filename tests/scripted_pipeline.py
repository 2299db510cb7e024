"""A core with scripted parts, and a confirmed track at frame 4."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

import tsr_engine.pipeline.core
from tsr_engine.evidence import FramePixels
from tsr_engine.gating.perceptual_hash import HashMemory
from tsr_engine.params import Params
from tsr_engine.params.gate import GateParams
from tsr_engine.pipeline import FrameInput, Models, TrackingCore
from tsr_engine.pipeline.track_context import WindowScorer
from tsr_engine.protocols import PixelSource
from tsr_engine.records import Detections, FloatArray, FrameEvidence, GateVerdict, Picture, Relocalisation, Sample

WIDTH, HEIGHT = 200, 160
NONE = Detections.empty()
PICTURE = np.random.default_rng(3).integers(0, 255, (HEIGHT, WIDTH, 3), dtype=np.uint8)


def detection(x: float, y: float = 50.0, side: float = 30.0, score: float = 3.0) -> Detections:
    one = np.array([score])
    return Detections(np.array([[x, y, x + side, y + side]]), one, np.array([0.5]), one)


class ScriptedGate:
    """A gate with a verdict set by the test."""

    margin = 0.1
    confident = True

    def __init__(self, params: GateParams) -> None:
        self.params = params

    def remember(self, memory: HashMemory, crop: Picture) -> HashMemory:
        return memory.add(crop)

    def judge(self, crop: Picture, memory: HashMemory, *args: object) -> GateVerdict:
        assert memory.count > 0
        value = 1.0 if ScriptedGate.confident else 99.0
        return GateVerdict(0.2, 5.0, 4.0, 2.0, value, value < self.params.tau)


class ScriptedClassifier:
    margin = 0.1
    class_id = 5

    def probabilities(self, crops: list[Picture]) -> np.ndarray:
        rows = np.full((len(crops), 43), 0.2 / 42, np.float32)
        rows[:, ScriptedClassifier.class_id] = 0.8
        return rows


@dataclass
class ScriptedLearner:
    """An online detector that records its calls and answers with a window to the left."""

    calls: list[tuple[str | int, ...]] = field(default_factory=list)
    probability: float = 0.9
    moved: float = 6.0
    grown: float = 0.0

    def learn(self, pixels: PixelSource, box: FloatArray, label: int, frame: int) -> tuple[Sample, ...]:
        self.calls.append(("learn", label, frame))
        return (Sample("learned", label, "prediction", frame),)

    def relocalise(self, pixels: PixelSource, box: FloatArray) -> Relocalisation | None:
        self.calls.append(("relocalise",))
        moved = box - self.moved * np.array([1.0, 0.0, 1.0, 0.0])
        moved += 0.5 * self.grown * np.array([-1.0, -1.0, 1.0, 1.0])
        return Relocalisation(box, moved, 2.0, self.probability, box, 0.0, 9)


@pytest.fixture(autouse=True)
def plain_gate(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tsr_engine.pipeline.core, "Gate", ScriptedGate)
    ScriptedGate.confident = True
    ScriptedClassifier.class_id = 5


class ScriptedPipeline:
    """A core with a confirmed track at frame 4, and the learner of that track."""

    def __init__(self, **settings: object) -> None:
        params = Params().with_settings([("confirm_hits", 1), ("confirm_window", 3), *settings.items()])
        self.learner = ScriptedLearner()

        def make(pixels: PixelSource, box: FloatArray, frame: int) -> tuple[ScriptedLearner, tuple[Sample, ...]]:
            return self.learner, (Sample("learned", 1, "result", frame),)

        self.models = Models(ScriptedClassifier(), make)
        self.core = TrackingCore(params, self.models, WIDTH, HEIGHT, interval=0.04)
        self.k = -1
        for _ in range(5):
            self.step(detection(80.0))
        self.learner.calls.clear()

    def rescore_by(self, scorer: WindowScorer) -> None:
        """Let another function rescore windows."""
        self.core._models = replace(self.models, window_scorer=scorer)

    def step(self, found: Detections) -> FrameEvidence:
        self.k += 1
        return self.core.step(FrameInput(self.k, self.k * 0.04, found, (0.0, 0.0), FramePixels(PICTURE)))
