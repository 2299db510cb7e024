"""The effect of an option of the detector's training, on drawn scenes."""

from __future__ import annotations

import io
import json
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from benchmarks.tuning.detector import main, parts, plan_with
from tests.training.toy_scenes import write_gtsdb
from tsr_engine.detection.acf import AcfModel
from tsr_engine.errors import UsageError
from tsr_engine.io.gtsdb import read_gtsdb
from tsr_engine.training.public.detector import DetectorPlan, fit_detector
from tsr_engine.training.public.detector_components import split_scenes

SMALL = (
    "rounds=[16, 32]", "mining_share=[1.0]", "feature_share=0.25", "jittered=4", "per_scene=30",
    "sign_verifier.steps=40", "sign_verifier.drawn_crops=2", "sign_verifier.rings=2",
    "sign_verifier.batch=32", "sign_verifier.network.filters=8", "sign_verifier.network.hidden=24",
    "sign_verifier.network.warm_up=10",
    "refinement.views=1", "refinement.starts=4", "refinement.candidates=20", "refinement.boosting.trees=32",
    "refinement.boosting.depth=3", "refinement.boosting.feature_share=0.125", "box_refinement.steps=40",
    "box_refinement.batch=32",
    "box_refinement.network.filters=8", "box_refinement.network.hidden=16", "box_refinement.network.warm_up=10",
)  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_gtsdb(tmp_path_factory.mktemp("scenes"), 24, 1)


def test_each_scene_is_held_out_once_without_reported_scenes(folder: Path) -> None:
    scenes = read_gtsdb(folder)
    _, _, reported = split_scenes(scenes, 3)
    cut = parts(scenes, 3, 3)
    held = [s.path for _, part in cut for s in part]
    assert sorted(held) == sorted({s.path for s in scenes} - {s.path for s in reported})
    for train, part in cut:
        assert not {s.path for s in train} & {s.path for s in part}
        assert len(train) + len(part) == len(held)


def test_values_are_set_by_name() -> None:
    plan = plan_with(["shrinkage=1", "rounds=[8, 16]", "refinement.boosting.trees=32", "floors=[[24, -1.0]]"])
    assert (plan.shrinkage, plan.rounds, plan.floors) == (1, (8, 16), ((24, -1.0),))
    assert plan.refinement.boosting.trees == 32
    assert plan.refinement.boosting.depth == DetectorPlan().refinement.boosting.depth
    assert plan_with([]) == DetectorPlan()


@pytest.mark.parametrize(
    ("setting", "reported"),
    [
        ("shrinkages=1", "no option 'shrinkages'"),
        ("refinement.tree=1", "no option 'refinement.tree'"),
        ("shrinkage.x=1", "no option 'shrinkage.x'"),
        ("shrinkage=half", "must be JSON"),
        ("refinement=3", "is a group of options"),
        ("refinement.boosting.depth=9", "depth must be in 1..5"),
        ('shrinkage="half"', "shrinkage cannot be 'half'"),
        ("rounds=8", "rounds cannot be 8"),
        ("sign_verifier.steps=1.5", "sign_verifier.steps cannot be 1.5"),
    ],
)
def test_a_wrong_option_is_named(setting: str, reported: str) -> None:
    with pytest.raises(UsageError, match=reported):
        plan_with([setting])


def test_wrong_use_is_refused_in_a_sentence(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--gtsdb", str(folder), "--part", "3"]) == UsageError.exit_code
    assert "tuning.detector: There must be two parts or more" in capsys.readouterr().err


def call(folder: Path, *more: str) -> list[str]:
    """Arguments of a call that trains a small detector."""
    small = [word for setting in SMALL for word in ("--set", setting)]
    return ["--gtsdb", str(folder), "--parts", "2", "--part", "1", "--seed", "3", *small, *more]


class TrainedPart(NamedTuple):
    """The printed row of a part, and the model that was trained for it."""

    row: dict[str, Any]
    model: tuple[AcfModel, dict[str, Any]]


@pytest.fixture(scope="module")
def trained(folder: Path) -> TrainedPart:
    models: list[tuple[AcfModel, dict[str, Any]]] = []

    def fit(*arguments: Any) -> tuple[AcfModel, dict[str, Any]]:
        models.append(fit_detector(*arguments))
        return models[-1]

    with pytest.MonkeyPatch.context() as patch, redirect_stdout(io.StringIO()) as said:
        patch.setattr("benchmarks.tuning.detector.fit_detector", fit)
        assert main(call(folder)) == 0
    return TrainedPart(json.loads(said.getvalue()), *models)


def test_a_part_is_trained_and_reported(folder: Path, trained: TrainedPart) -> None:
    row, held = trained.row, parts(read_gtsdb(folder), 2, 3)[1][1]
    assert row["part"] == 1
    assert row["set"] == list(SMALL)
    assert (row["pictures"], row["signs"]) == (len(held), sum(len(s.boxes) for s in held))
    assert 0.5 < row["ap50"] <= 1
    assert 0 <= row["lost"] <= 0.4 * row["signs"]


def test_passes_of_the_box_refinement(
    folder: Path, trained: TrainedPart, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """They change what the trained model finds."""
    monkeypatch.setattr("benchmarks.tuning.detector.fit_detector", lambda *_: trained.model)
    assert main(call(folder, "--passes", "0")) == 0
    assert json.loads(capsys.readouterr().out)["mean_eq7"] != trained.row["mean_eq7"]
    assert main(call(folder, "--passes", "9")) == UsageError.exit_code
    assert "--passes cannot be 9" in capsys.readouterr().err
