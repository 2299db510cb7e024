"""`tsr eval`, `tsr train` and `tsr sample` on small data, with toy parts where a model is needed."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

import tsr_engine.pipeline
from tests import toy_pipeline
from tsr_engine.cli import evaluate
from tsr_engine.cli.main import run
from tsr_engine.io import models
from tsr_engine.io.models import Component, load_component
from tsr_engine.labels.classes import default_keys
from tsr_engine.recognition.gtsrb_classes import CLASS_NAMES

Capture = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def toy_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tsr_engine.pipeline, "load_components", toy_pipeline.load_components)
    monkeypatch.setattr(tsr_engine.pipeline, "load_reader", lambda *asked: toy_pipeline.HueClassifier())
    monkeypatch.setattr(tsr_engine.pipeline, "load_detector", lambda params, folder=None: toy_pipeline.RedDetector())


@pytest.fixture
def annotated(tmp_path: Path) -> Path:
    """A toy drive with its exact ground truth in the folder gt."""
    folder = tmp_path / "clips"
    (folder / "gt").mkdir(parents=True)
    toy_pipeline.write_drive(folder / "drive.mp4", 36)
    rows = ["frame,track_id,x1,y1,x2,y2,class_id,visibility,ignore"]
    for k in range(36):
        box = toy_pipeline.sign_box(k)
        if box is not None:
            rows.append(f"{k},1,{','.join(f'{v:.2f}' for v in box)},14,1.0,0")
    (folder / "gt" / "drive.csv").write_text("\n".join(rows) + "\n")
    return folder


def test_eval_tracking(annotated: Path, tmp_path: Path, capsys: Capture) -> None:
    assert run(["eval", "tracking", str(annotated), "--kf-alone", "--out", str(tmp_path / "report"), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert set(report) == {"default", "KF alone"}
    assert report["default"]["signs"] == report["default"]["signs_detected"] == 1
    assert 0 < report["default"]["mean_error"] < 0.4
    assert report["KF alone"]["mean_error_by_source"].keys() <= {"detected", "predicted"}
    assert json.loads((tmp_path / "report" / "tracking.json").read_text()) == report
    assert (tmp_path / "report" / "tracking_error.png").read_bytes().startswith(b"\x89PNG")


def test_ground_truth_beyond_the_video_is_refused_before_tracking(
    annotated: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(evaluate, "track_without_files", None)
    with (annotated / "gt" / "drive.csv").open("a") as table:
        table.write("500,1,10,10,40,40,14,1,0\n")
    assert run(["eval", "tracking", str(annotated)]) == 3
    assert "frame must be a whole number from 0 to 35, got 500" in capsys.readouterr().err


def test_eval_tracking_of_given_rows(annotated: Path, tmp_path: Path, capsys: Capture) -> None:
    rows = ["frame,track_id,x1,y1,x2,y2,class_id,score,source"]
    truth = (annotated / "gt" / "drive.csv").read_text().splitlines()[1:]
    rows += [",".join([*line.split(",")[:7], "3.0", "detected"]) for line in truth]
    (tmp_path / "drive.csv").write_text("\n".join(rows) + "\n")
    video = str(annotated / "drive.mp4")
    assert run(["eval", "tracking", video, "--results", str(tmp_path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)["default"]
    assert report["mean_error"] == pytest.approx(0.0, abs=1e-9)
    assert report["coverage"] == 1.0
    assert report["signs_classified"] == 1
    assert run(["eval", "tracking", video, "--truth", str(tmp_path / "none")]) == 3
    assert "There is no ground truth drive.csv" in capsys.readouterr().err
    assert run(["eval", "tracking", video, "--results", str(tmp_path / "none")]) == 3
    assert "There is no drive.csv for drive.mp4" in capsys.readouterr().err
    assert run(["eval", "tracking", video, "--min-width", "nan"]) == 2
    assert "--min-width expects px, 0 or more. Got nan." in capsys.readouterr().err


@pytest.mark.parametrize("words", ["--kf-alone", "--preset paper", "--set tau=3", "--models m"])
def test_given_rows_are_not_tracked(words: str, annotated: Path, tmp_path: Path, capsys: Capture) -> None:
    command = ["eval", "tracking", str(annotated / "drive.mp4"), "--results", str(tmp_path), *words.split()]
    assert run(command) == 2
    assert f"{words.split()[0]} says how to track, and --results has it done." in capsys.readouterr().err


def test_rows_are_found_by_the_name_of_an_export(annotated: Path, tmp_path: Path, capsys: Capture) -> None:
    for suffix in ("mp4", "csv"):
        source = annotated / ("gt" if suffix == "csv" else "") / f"drive.{suffix}"
        (tmp_path / f"my_drive.{suffix}").write_bytes(source.read_bytes())
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "my-drive.csv").write_text("frame,track_id,x1,y1,x2,y2,class_id,score,source\n")
    command = ["eval", "tracking", str(tmp_path / "my_drive.mp4"), "--results", str(tmp_path / "out"), "--json"]
    assert run(command) == 0
    assert json.loads(capsys.readouterr().out)["default"]["signs_detected"] == 0


def test_a_damaged_video_does_not_stop_the_evaluation_of_others(
    annotated: Path, tmp_path: Path, capsys: Capture
) -> None:
    rows = "frame,track_id,x1,y1,x2,y2,class_id,score,source\n"
    truth = (annotated / "gt" / "drive.csv").read_bytes()
    for name, content in (("good", (annotated / "drive.mp4").read_bytes()), ("bad", b"no video")):
        (tmp_path / f"{name}.mp4").write_bytes(content)
        (tmp_path / f"{name}.csv").write_bytes(truth)
        (tmp_path / "rows").mkdir(exist_ok=True)
        (tmp_path / "rows" / f"{name}.csv").write_text(rows)
    command = ["eval", "tracking", str(tmp_path), "--results", str(tmp_path / "rows"), "--json"]
    assert run(command) == 3
    captured = capsys.readouterr()
    assert [v["video"] for v in json.loads(captured.out)["default"]["by_video"]] == ["good.mp4"]
    assert "bad.mp4" in captured.err
    assert "1 of 2 videos could not be read; the figures are of the rest." in captured.err
    assert run([*command, "--out", str(tmp_path / "good.csv")]) == 6
    assert "a file stands where a folder is needed" in capsys.readouterr().err


@pytest.fixture
def scenes(tmp_path: Path) -> Path:
    """A few toy pictures in the layout of GTSDB."""
    folder = tmp_path / "gtsdb"
    folder.mkdir()
    lines = []
    for number, k in enumerate((8, 12, 16, 20, 24, 0)):
        cv2.imwrite(str(folder / f"{number:05d}.png"), toy_pipeline.drive_picture(k))
        box = toy_pipeline.sign_box(k)
        if box is not None:
            left, top, right, bottom = np.round(box).astype(int)
            lines.append(f"{number:05d}.png;{left};{top};{right - 1};{bottom - 1};14")
    (folder / "gt.txt").write_text("\n".join(lines) + "\n")
    return folder


def test_eval_detection(scenes: Path, tmp_path: Path, capsys: Capture) -> None:
    assert run(["eval", "detection", "--gtsdb", str(scenes), "--out", str(tmp_path / "report"), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert set(report) == {"with prior", "raw score"}
    assert report["raw score"]["pictures"] == 6
    assert report["raw score"]["signs"] == 5
    assert 0.3 < report["raw score"]["average_precision"] <= 1.0
    assert (tmp_path / "report" / "precision_recall.png").read_bytes().startswith(b"\x89PNG")


def test_eval_detection_refuses_what_it_cannot_score(
    scenes: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    trained = Component("detector", {}, data={"scenes": {"scenes": 600}}, seed=0)
    monkeypatch.setattr(models, "load_component", lambda name, folder=None: trained)
    assert run(["eval", "detection", "--gtsdb", str(scenes), "--held-out"]) == 3
    assert "held out of 600, but --gtsdb has 6. Name the scenes of the training" in capsys.readouterr().err
    (scenes / "gt.txt").write_text("")
    assert run(["eval", "detection", "--gtsdb", str(scenes)]) == 3
    assert "has no scene with signs to score" in capsys.readouterr().err


def test_train_online(scenes: Path, tmp_path: Path, capsys: Capture) -> None:
    command = ["train", "online", "--gtsdb", str(scenes), "--seed", "3", "--json", "--out"]
    digests = []
    for name in ("a", "b"):
        assert run([*command, str(tmp_path / name)]) == 0
        digests.append(json.loads(capsys.readouterr().out)["components"]["online"]["sha256"])
    assert digests[0] == digests[1]
    component = load_component("online", tmp_path / "a")
    assert component.seed == 3
    assert set(component.arrays) == {"X", "y"}


@pytest.fixture
def crops(tmp_path: Path) -> Path:
    """Two classes with two tracks each in the layout of GTSRB."""
    for class_id in (3, 14):
        folder = tmp_path / "gtsrb" / f"{class_id:05d}"
        folder.mkdir(parents=True)
        rows = ["Filename;Width;Height;Roi.X1;Roi.Y1;Roi.X2;Roi.Y2;ClassId"]
        for number in range(2):
            for frame in range(3):
                name = f"{number:05d}_{frame:05d}.png"
                cv2.imwrite(str(folder / name), np.full((40, 40, 3), class_id, np.uint8))
                rows.append(f"{name};40;40;5;5;35;35;{class_id}")
        (folder / f"GT-{class_id:05d}.csv").write_text("\n".join(rows) + "\n")
    return tmp_path / "gtsrb"


def test_eval_classification(crops: Path, tmp_path: Path, capsys: Capture) -> None:
    command = ["eval", "classification", "--gtsrb", str(crops), "--json"]
    assert run([*command, "--out", str(tmp_path / "report")]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["crops"], report["accuracy"]) == (12, 1.0)
    assert (tmp_path / "report" / "confusion.png").read_bytes().startswith(b"\x89PNG")
    assert run([*command, "--held-out", "0.5"]) == 0
    assert json.loads(capsys.readouterr().out)["crops"] == 6
    assert run([*command, "--held-out", "1.5"]) == 2


def test_eval_fusion(crops: Path, tmp_path: Path, capsys: Capture) -> None:
    assert run(["eval", "fusion", "--gtsrb", str(crops), "--out", str(tmp_path / "report")]) == 0
    assert "4 tracks; 1.0000 of their single crops are right." in capsys.readouterr().out
    report = json.loads((tmp_path / "report" / "fusion.json").read_text())
    assert report["rates"]["scale"][0] == 1.0


@pytest.mark.parametrize("command", ["classification", "fusion"])
def test_models_with_a_taught_label_are_measured(
    crops: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    class Taught(toy_pipeline.HueClassifier):  # type: ignore[name-defined, misc]
        labels = (*default_keys(), "no-parking")

        def probabilities(self, crops: list[np.ndarray]) -> np.ndarray:
            known = super().probabilities(crops)
            taught = [[1.0 if int(crop.mean()) == 3 else 0.0] for crop in crops]
            return np.hstack([known * 0.5, np.array(taught, np.float32)])

    monkeypatch.setattr(tsr_engine.pipeline, "load_reader", lambda *asked: Taught())
    assert run(["eval", command, "--gtsrb", str(crops)]) == 0
    out = capsys.readouterr().out
    assert "0.5000 of" in out
    assert (f"6 times '{CLASS_NAMES[3]}' was taken for 'no-parking'" in out) == (command == "classification")


@pytest.mark.parametrize("command", ["classification", "fusion"])
def test_a_class_of_one_track_has_nothing_to_hold_out(crops: Path, capsys: Capture, command: str) -> None:
    table = crops / "00003" / "GT-00003.csv"
    table.write_text("\n".join(table.read_text().splitlines()[:4]) + "\n")
    assert run(["eval", command, "--gtsrb", str(crops / "00003"), "--held-out", "0.5"]) == 3
    assert "--held-out needs two tracks of one class" in capsys.readouterr().err


def test_sample_renders_a_drive_or_refuses_bad_options(tmp_path: Path, capsys: Capture) -> None:
    command = ["sample", "--out", str(tmp_path / "s"), "--seconds", "0.2", "--size", "320x180", "--fps", "10"]
    assert run([*command, "--json"]) == 0
    paths = json.loads(capsys.readouterr().out)
    assert all(Path(path).stat().st_size > 0 for path in paths.values())
    for bad in (["--size", "wide"], ["--seconds", "-1"], ["--scenario", "moon"]):
        assert run(["sample", "--out", str(tmp_path / "s"), *bad]) == 2
        assert capsys.readouterr().err.startswith("tsr: ")


def test_an_interrupted_sample_keeps_the_older_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    command = ["sample", "--out", str(tmp_path), "--seconds", "0.4", "--size", "320x180", "--fps", "10"]
    assert run([*command, "--scenario", "country_road"]) == 0
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert len(before) == 3

    def cut(self: object, picture: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("sample_videos.encode.Encoder.add", cut)
    assert run([*command, "--scenario", "country_road"]) == 130
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
