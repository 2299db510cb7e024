"""From files to a refined version: the command line, resumed complete trainings, the memory."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from tests.training.corrected_tracks import make_track, make_video, write_video
from tests.training.toy_scenes import write_gtsdb
from tsr_engine.cli.main import run
from tsr_engine.detection.acf import AcfModel
from tsr_engine.errors import ModelError, UsageError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.registry import format_named
from tsr_engine.io.gtsdb import read_gtsdb
from tsr_engine.io.gtsrb import CropItem
from tsr_engine.io.models import SHIPPED, load_component, read_manifest, save_component
from tsr_engine.io.video_probe import video_sha256
from tsr_engine.labels.classes import default_keys
from tsr_engine.labels.files import DEFAULT, shipped_set
from tsr_engine.labels.model import Label, LabelSet
from tsr_engine.pipeline import load_reader, make_reader
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.recognition.mixture import Mixture
from tsr_engine.training.corrections import network_choice, retrain
from tsr_engine.training.corrections.corrected_scenes import CorrectedScene
from tsr_engine.training.corrections.public_figures import remembered_figures
from tsr_engine.training.corrections.refine_classifier import SignCrop
from tsr_engine.training.corrections.refine_prior import SceneDetections, held_out_detections
from tsr_engine.training.corrections.retrain import Recipe
from tsr_engine.training.progress import Progress
from tsr_engine.training.public import train_parts
from tsr_engine.training.public.memory import build_memory
from tsr_engine.training.synthetic.classifier_augmentation import LoadedCrop, plain_view


@pytest.fixture(scope="module")
def corrections(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """An export of two accepted signs, and its video."""
    folder = tmp_path_factory.mktemp("export")
    tracks = [make_track("m1", 4), make_track("m2", 4, first=5, side=30.0)]
    path = write_video(folder / "toy.mp4", tracks, 10)
    dataset = Dataset(shipped_set(DEFAULT), (replace(make_video(tracks, path, 10), sha256=video_sha256(path)),))
    export_dataset(dataset, format_named("cvat-video"), folder / "e.zip", ExportOptions(), zipped=True)
    return folder / "e.zip", path


@pytest.fixture(scope="module")
def refined(corrections: tuple[Path, Path], tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A version with all parts refined, and the command's output."""
    export, path = corrections
    out = tmp_path_factory.mktemp("version") / "models"
    lines: list[str] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tsr_engine.cli.train.print_json", lambda content: lines.append(json.dumps(content)))
        words = ["train", "all", "--export", str(export), "--video", str(path), "--out", str(out), "--json"]
        assert run(words) == 0
    return out, lines[0]


def test_the_command_writes_a_complete_version(refined: tuple[Path, str]) -> None:
    out, said = refined
    content = json.loads(said)
    kept = {"memory", "other_shapes"}
    assert set(content["components"]) == {"detector", "prior", "classifier", "online", *kept}
    for name, digest in content["components"].items():
        assert load_component(name, out).sha256 == digest
        assert (digest == load_component(name, SHIPPED).sha256) == (name in kept)
    assert content["figures"]["corrections"]["by"] == "sign"
    assert content["lineage"]["used"]["signs"] == 2
    assert not content["lineage"]["used"]["network"]["kept"], "it does not know the toy's drawings"
    assert "The network that reads signs" in content["lineage"]["notes"][-1]
    assert content["lineage"]["parent"]["models"]["prior"] == load_component("prior").sha256
    detector = load_component("detector", out)
    assert detector.data["refined"]["signs"] == 2
    assert "heldout_boxes" in detector.arrays


def test_the_same_seed_gives_the_same_bytes_and_a_version_can_be_refined_again(
    refined: tuple[Path, str],
    corrections: tuple[Path, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    out, _ = refined
    export, path = corrections
    words = ["--export", str(export), "--video", str(path)]
    assert run(["train", "all", *words, "--out", str(tmp_path / "again")]) == 0
    assert read_manifest(tmp_path / "again")["components"] == read_manifest(out)["components"]
    assert run(["train", "all", *words, "--out", str(out)]) == 2
    assert "holds a version already, which is never overwritten" in capsys.readouterr().err
    looked_at: list[int] = []

    def detections(model: AcfModel, scenes: Sequence[CorrectedScene], progress: Progress) -> SceneDetections:
        looked_at.append(len(scenes))
        return held_out_detections(model, scenes, progress)

    monkeypatch.setattr(retrain, "held_out_detections", detections)
    assert run(["train", "lambda", *words, "--from", str(out), "--out", str(tmp_path / "child")]) == 0
    assert looked_at == [0, 0], "the detector has learned from the only video"
    said = capsys.readouterr().out.replace("\n", " ")
    assert "has learned from 1 of 1 video with held-out signs, so the figures of both versions are too high" in said
    parent, child = (read_manifest(folder)["components"] for folder in (out, tmp_path / "child"))
    assert {n for n in child if child[n]["sha256"] != parent[n]["sha256"]} <= {"prior"}
    assert child["prior"]["data"]["centres"] == parent["prior"]["data"]["centres"]


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["lambda", "--out", "{out}"], 2, "name --export"),
        (["online", "--from", "{here}", "--gtsdb", "{here}", "--out", "{out}"], 2, "go with --export"),
        (["online", "--export", "{export}", "--from", "{here}", "--out", "{here}"], 2, "never overwritten"),
        (["online", "--export", "{export}", "--out", "{out}"], 3, "is missing and the export has no pictures"),
        (["online", "--export", "{export}", "--video", "{here}/none.mp4", "--out", "{out}"], 3, "There is no video at"),
        (["online", "--export", "{export}", "--video", "{export}", "--out", "{out}"], 3, "warning: no export is of"),
        (["memory", "--gtsdb", "{here}", "--out", "{out}"], 2, "needs --gtsrb DIR"),
        (["prior", "--gtsdb", "{here}", "--out", "{out}"], 2, "Training prior needs the detector, which"),
        (["memory", "--gtsdb", "{here}", "--gtsrb", "{here}", "--out", "{out}"], 2, "needs the detector, which"),
        (["other-shapes", "--signs", "x.json", "--out", "{out}"], 2, "Training other-shapes needs --gtsdb DIR"),
    ],
)
def test_refusals_of_the_command(
    words: list[str], code: int, said: str, corrections: tuple[Path, Path], tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    places = {"here": tmp_path, "out": tmp_path / "out", "export": corrections[0]}
    assert run(["train", *(word.format(**places) for word in words)]) == code
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_label_that_the_model_lacks_is_added(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ours = LabelSet(key="ours", name="Ours", next_id=9, labels=(Label(id=7, key="bus-stop", name="bus stop"),))
    tracks = [
        replace(make_track(f"m{k}", 4, side=30.0, label=7), boxes=make_track("", 4, side=30.0).boxes + 90 * k)
        for k in (0, 1)
    ]
    path = write_video(tmp_path / "toy.mp4", tracks, 10)
    dataset = Dataset(ours, (replace(make_video(tracks, path, 10), sha256=video_sha256(path)),))
    export_dataset(dataset, format_named("cvat-video"), tmp_path / "e.zip", ExportOptions(), zipped=True)
    words = ["train", "classifier", "--export", str(tmp_path / "e.zip"), "--video", str(path)]
    assert run([*words, "--out", str(tmp_path / "models")]) == 0
    assert "bus-stop: a label that the earlier version lacks" in capsys.readouterr().out.replace("\n", " ")
    reads = load_reader(tmp_path / "models")
    assert isinstance(reads, Mixture)
    assert reads.labels == (*default_keys(), "bus-stop")
    assert reads.known == (*range(43), -1), "the network lacks the new label"


def test_versions_are_compared_with_their_readers(
    corrections: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    export, path = corrections
    readers: list[object] = []

    def reading(reader: object, crops: object) -> dict[str, float]:
        readers.append(reader)
        return {"crops_right": 1.0, "signs_right": 1.0}

    monkeypatch.setattr(retrain, "evaluate_reading", reading)
    monkeypatch.setattr(network_choice, "right_shares", lambda answers, crops: {"signs_right": 1.0})
    words = ["train", "classifier", "--export", str(export), "--video", str(path), "--out", str(tmp_path / "models")]
    assert run(words) == 0
    assert [type(reader) for reader in readers] == [Mixture, Mixture]


def test_a_version_leaves_out_a_network_that_contradicts_the_corrections() -> None:
    parts = {name: load_component(name) for name in ("classifier", "network_classifier")}
    rng = np.random.default_rng(0)
    crops = [
        LoadedCrop(rng.integers(0, 256, (48, 48, 3), np.uint8), np.array([5.0, 5.0, 43.0, 43.0]), -1) for _ in range(60)
    ]
    views = [plain_view(crop) for crop in crops]
    alone = SignClassifier.from_component(parts["classifier"]).probabilities(views).argmax(axis=1)
    both = make_reader(parts).probabilities(views).argmax(axis=1)
    differ = np.flatnonzero(alone != both)
    assert len(differ)
    for answers, kept in ((alone, False), (both, True)):
        signs = [SignCrop(replace(crops[k], class_id=int(answers[k])), f"s{k}") for k in differ]
        found = network_choice.compare_with_network(parts, signs)
        assert found == {"kept": kept, "signs_right": float(kept), "signs_right_without": float(not kept)}
        assert len(network_choice.network_note(found)) == (not kept)


def test_a_memory_of_other_features_is_refused() -> None:
    memory = load_component("memory")
    other = replace(memory, arrays={**memory.arrays, "moment": np.eye(257)})
    with pytest.raises(ModelError, match="other features"):
        retrain._refine_classifier_part(load_component("classifier"), [], other, Recipe(), ignore_progress)


def test_unknown_parts_are_refused() -> None:
    with pytest.raises(UsageError, match="Got wheels"):
        Recipe(parts=("detector", "wheels"))


def ignore_progress(_stage: str, _done: int, _total: int) -> None:
    """Ignore progress."""


def test_a_complete_training_copies_other_parts_and_resumes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenes = write_gtsdb(tmp_path / "scenes", 4, 1)
    report = train_parts.train_parts(("online",), None, tmp_path / "out", 0, ignore_progress, gtsdb=scenes)
    shipped = {name: entry["sha256"] for name, entry in read_manifest(SHIPPED)["components"].items()}
    assert {name for name in report.models if report.models[name] != shipped[name]} == {"online"}

    def never(*_: Any) -> None:
        raise AssertionError("it is trained already")

    monkeypatch.setattr(train_parts, "train_component", never)
    assert (
        train_parts.train_parts(("online",), None, tmp_path / "out", 0, ignore_progress, gtsdb=scenes).models
        == report.models
    )
    assert "labels" not in report.lineage
    keys = [f"k{number}" for number in range(43)]
    classifier = load_component("classifier")
    save_component(replace(classifier, params={**classifier.params, "labels": keys}), tmp_path / "parent")
    save_component(load_component("online"), tmp_path / "parent")
    monkeypatch.undo()
    child = train_parts.train_parts(
        ("online",), tmp_path / "parent", tmp_path / "child", 0, ignore_progress, gtsdb=scenes
    )
    assert child.lineage["labels"] == keys, "the classifier of the parent is taken over with its labels"
    with pytest.raises(UsageError, match="classifier needs gtsrb"):
        train_parts.train_parts(("classifier",), None, tmp_path / "other", 0, ignore_progress, gtsdb=scenes)


def test_a_memory_of_scenes_and_crops(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    items = []
    for number in range(4):
        path = tmp_path / f"{number:05d}_00000.png"
        cv2.imwrite(str(path), rng.integers(0, 255, (40, 40, 3), dtype=np.uint8))
        items.append(CropItem(path, (5, 5, 35, 35), number % 2, (number % 2, number), 0))
    detector, classifier = load_component("detector"), load_component("classifier")
    built = build_memory(
        read_gtsdb(write_gtsdb(tmp_path / "scenes", 5, 3)),
        items,
        AcfModel.from_arrays(detector.arrays, detector.params),
        SignClassifier.from_component(classifier),
        0,
        ignore_progress,
    )
    a = built.arrays
    assert a["signs"].shape[1] == a["others"].shape[1] == 4000
    assert len(a["signs"]) == len(a["signs_cascade"]) > 4
    features = len(classifier.arrays["hidden_bias"])
    assert a["moment"].shape == (features + 1, features + 1)
    np.testing.assert_allclose(a["moment"], a["moment"].T, rtol=1e-5)
    assert a["moment"][-1, -1] == pytest.approx(1.0)
    assert sorted(a["classes"].tolist()) == [0, 0, 1, 1]
    save_component(built, tmp_path / "m")
    parts = {"detector": detector, "classifier": classifier, "memory": load_component("memory", tmp_path / "m")}
    assert set(remembered_figures(parts)) == {"signs_kept", "others_kept", "crops_kept"}
    assert remembered_figures({"detector": detector, "classifier": classifier}) == {}
