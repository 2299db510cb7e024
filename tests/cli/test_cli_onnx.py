"""An ONNX network in place of the shipped detector, from the command line."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import cv2
import pytest

from tests import toy_pipeline
from tests.detection.test_onnx import redness_network
from tsr_engine.cli.main import run
from tsr_engine.evidence import EvidenceReader

pytest.importorskip("onnx")
Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def network(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One convolution that detects red, for an input of 128x128 px."""
    path = tmp_path_factory.mktemp("onnx") / "red.onnx"
    path.write_bytes(redness_network(128, 16, "v8"))
    return path


def test_track_records_the_network_instead_of_the_detector(network: Path, tmp_path: Path, capsys: Capture) -> None:
    video = toy_pipeline.write_drive(tmp_path / "drive.mp4", 12)
    command = ["track", str(video), "--evidence", str(tmp_path / "run"), "--onnx", str(network), "--json"]
    assert run([*command, "--onnx-size", "128x128", "--set", "keep_score=-4"]) == 0, capsys.readouterr().err
    assert json.loads(capsys.readouterr().out)["frames"] == 12
    with EvidenceReader(tmp_path / "run") as reader:
        models = reader.header.models
        assert models["onnx 128x128 v8"] == hashlib.sha256(network.read_bytes()).hexdigest()
        assert "detector" not in models
        assert sum(len(frame.detections.boxes) for frame in reader.frames(pixels=False)) > 0
    assert run(["replay", str(tmp_path / "run"), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["identical_frames"] == report["frames"] == 12


def test_detect_finds_what_the_network_sees(network: Path, tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), toy_pipeline.drive_picture(25))
    out = tmp_path / "o.jsonl"
    command = ["detect", str(tmp_path / "a.png"), "--jsonl", str(out), "--onnx", str(network)]
    assert run([*command, "--onnx-size", "128x128", "--set", "keep_score=-4"]) == 0
    (line,) = map(json.loads, out.read_text().splitlines())
    x1, y1, x2, y2 = toy_pipeline.sign_box(25)
    reddest = max(line["detections"], key=lambda d: d["raw_score"])
    assert reddest["x1"] < x2
    assert reddest["x2"] > x1
    assert reddest["y1"] < y2
    assert reddest["y2"] > y1


@pytest.mark.parametrize(
    ("content", "options", "code", "words"),
    [
        (None, [], 4, "Cannot read the network"),
        (b"", [], 4, "is empty"),
        (b"not a network at all", [], 4, "not a network"),
        ("network", ["--onnx-size", "640x640"], 4, "Choose --onnx-size and --onnx-layout"),
        ("network", ["--onnx-size", "128x128", "--onnx-layout", "v5"], 4, "Choose --onnx-size and --onnx-layout"),
        ("network", ["--onnx-size", "wide"], 2, "--onnx-size expects WxH"),
        ("network", ["--onnx-layout", "v7"], 2, "--onnx-layout expects v8 or v5"),
    ],
)
def test_an_unusable_network_is_refused_in_one_sentence(
    content: object, options: list[str], code: int, words: str, network: Path, tmp_path: Path, capfd: Capture
) -> None:
    path = network if content == "network" else tmp_path / "net.onnx"
    if isinstance(content, bytes):
        path.write_bytes(content)
    cv2.imwrite(str(tmp_path / "a.png"), toy_pipeline.drive_picture(25))
    command = ["detect", str(tmp_path / "a.png"), "--jsonl", str(tmp_path / "o.jsonl"), "--onnx", str(path)]
    assert run([*command, *options]) == code
    err = capfd.readouterr().err.strip().splitlines()
    assert len(err) == 1, err
    assert words in err[0]
    assert not (tmp_path / "o.jsonl").exists()
