"""The comparison with YOLO11n: scenes for its training, errors of boxes, missing parts, and the report."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.deep.train_yolo import main, write_scenes
from benchmarks.experiment import ROOT, Data, Result, Skip
from benchmarks.experiments import yolo


def test_scenes_are_written_as_the_trainer_reads_them(tmp_path: Path) -> None:
    source = tmp_path / "gtsdb"
    source.mkdir()
    for k in range(8):
        (source / f"0000{k}.jpg").write_bytes(cv2.imencode(".jpg", np.zeros((40, 80, 3), np.uint8))[1].tobytes())
    (source / "gt.txt").write_text("".join(f"0000{k}.jpg;10;8;29;19;{k}\n" for k in range(8) if k != 3))
    folder = tmp_path / "scenes"
    folder.mkdir()
    (folder / "older.txt").write_text("of an earlier call")

    write_scenes(source, folder)

    labels = {path.stem: path.read_text() for path in (folder / "labels").iterdir()}
    kept = {path.stem for path in (folder / "images").iterdir()}
    assert kept == set(labels)
    assert len(kept) == 6  # two of eight scenes are reported on
    # left 10, right 30 of 80 px; top 8, bottom 20 of 40 px
    assert {text for stem, text in labels.items() if stem != "00003"} == {"0 0.2500000 0.3500000 0.2500000 0.3000000\n"}
    assert labels.get("00003", "") == ""
    counts = json.loads((folder / "counts.json").read_text())
    assert counts["scenes"] == 6
    assert counts["signs"] == sum(bool(text) for text in labels.values())
    assert not (folder / "older.txt").exists()


@pytest.mark.parametrize("step", [[], ["--only", "scenes"], ["--only", "train"]])
def test_a_training_without_scenes_is_refused(
    tmp_path: Path, step: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["train_yolo", str(tmp_path), *step])
    with pytest.raises(SystemExit):
        main()
    assert f"there are no scenes in {tmp_path / 'scenes'} yet; name --gtsdb" in capsys.readouterr().err


def test_the_error_is_of_the_signs_found_at_the_rate() -> None:
    sign = np.array([[0.0, 0, 10, 10]])
    shifted, weak, nowhere = [0.0, 2, 10, 12], [50.0, 0, 60, 10], [80.0, 80, 90, 90]
    second = np.array([[50.0, 0, 60, 10]])
    pictures = [
        (np.array([shifted, nowhere]), np.array([3.0, 2.0]), sign),
        (np.array([weak]), np.array([1.0]), second),
    ]
    assert yolo.error_at_rate(pictures) == pytest.approx(0.2)  # the false detection is before the second sign
    assert yolo.error_at_rate([(np.array([shifted]), np.array([3.0]), sign), pictures[1]]) == pytest.approx(0.1)


def test_a_missing_network_names_the_command(tmp_path: Path) -> None:
    with pytest.raises(Skip, match=r"`python -m benchmarks\.deep\.train_yolo .*yolo --gtsdb GTSDB` makes it"):
        yolo.EXPERIMENT.run(Data(scratch=tmp_path))


def test_the_report_names_what_is_missing() -> None:
    result = Result.load(ROOT / "results" / "yolo.json")
    result.figures["foreign"] = {}
    result.figures["missing"]["ByteTrack"] = "the package trackers cannot be imported."
    text = yolo.EXPERIMENT.report(result)
    assert "*No pictures of other cameras were named.*" in text
    assert "*Skipped:* ByteTrack: the package trackers cannot be imported." in text
