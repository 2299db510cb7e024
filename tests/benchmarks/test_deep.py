"""The small deep detector: training crops and targets, the ONNX file, and reports on missing parts."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.deep.architecture import CONVOLUTIONS, STRIDE
from benchmarks.deep.crops import SIDE, Crop, HardNegatives, background, cut, on_sign, targets
from benchmarks.experiment import ROOT, Data, Result, Skip
from benchmarks.experiments import deep, yolo_time
from benchmarks.timing import contenders
from tsr_engine.detection.onnx import OnnxDetector
from tsr_engine.params.detector import DetectorParams


def scene_with(box: tuple[int, int, int, int]) -> np.ndarray:
    picture = np.full((500, 700, 3), 30, np.uint8)
    picture[box[1] : box[3], box[0] : box[2]] = 230
    return picture


@pytest.mark.parametrize("seed", range(6))
def test_boxes_follow_their_signs_through_augmentation(seed: int) -> None:
    rng = np.random.default_rng(seed)
    box = (300, 200, 340, 250)
    boxes = np.array([box], float)
    crop = cut(rng, scene_with(box), boxes, *on_sign(rng, boxes[0]))
    bright = crop.picture.max(axis=2) > (int(crop.picture.max()) + int(crop.picture.min())) / 2
    rows, columns = np.nonzero(bright)
    seen = np.array([columns.min(), rows.min(), columns.max() + 1, rows.max() + 1], float)
    assert crop.picture.shape == (SIDE, SIDE, 3)
    assert len(crop.boxes) == 1
    np.testing.assert_allclose(crop.boxes[0], seen, atol=1.6)


def test_cut_or_small_signs_are_ignored_in_training() -> None:
    boxes = np.array([[300.0, 200, 340, 250], [345, 210, 350, 215]])
    crop = cut(np.random.default_rng(1), scene_with((300, 200, 340, 250)), boxes, 1.0, 320.0 + SIDE / 2, 225.0)
    assert len(crop.boxes) == 0
    assert len(crop.ignored) == 2
    heatmap, _, weights = targets(crop)
    assert heatmap.min() == -1
    assert heatmap.max() <= 0
    assert weights.max() == 0


def test_the_target_peaks_at_the_centre_and_holds_the_edges() -> None:
    box = np.array([100.0, 60, 140, 120])
    crop = Crop(np.zeros((SIDE, SIDE, 3), np.uint8), box[None], np.zeros((0, 4)), (0.0, 0.0))
    heatmap, edges, weights = targets(crop)
    row, column = np.unravel_index(heatmap.argmax(), heatmap.shape)
    assert (row, column) == (90 // STRIDE, 120 // STRIDE)
    assert heatmap[row, column] == 1
    assert (heatmap == 1).sum() == 1
    np.testing.assert_array_equal(edges[:, weights > 0], np.tile(box[:, None], (1, int((weights > 0).sum()))))
    assert (weights > 0).sum() >= 1


def test_background_crops_stay_near_their_place() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        scale, x, y = background(rng, 700, 500, (400.0, 300.0))
        assert max(abs(x - 400), abs(y - 300)) * scale <= 0.6 * SIDE / 2 + 1e-6


def test_only_the_hardest_places_are_kept() -> None:
    hard = HardNegatives(most=2)
    for score in (0.1, 0.9, 0.5):
        hard.add(score, 3, 10 * score, 0.0)
    rng = np.random.default_rng(0)
    taken = [hard.pop(rng), hard.pop(rng)]
    assert {t[1] for t in taken if t is not None} == {9.0, 5.0}
    assert hard.pop(rng) is None


def made_weights(seed: int = 0) -> dict[str, np.ndarray]:
    """Weights that ignore the picture: every cell answers a box of 40x24 px around its centre, with p = 0.9."""
    rng = np.random.default_rng(seed)
    weights: dict[str, np.ndarray] = {}
    for c in CONVOLUTIONS.values():
        kernel = rng.normal(0, 0.05, (c.outputs, c.inputs, c.size, c.size)).astype(np.float32)
        if c.name == "answer":
            edges = np.log(np.array([20, 12, 20, 12]) / STRIDE)
            weights |= {"answer.weight": kernel * 0, "answer.bias": np.array([np.log(9), *edges], np.float32)}
            continue
        ones = np.ones(c.outputs, np.float32)
        norm = {"weight": ones, "bias": ones * 0.1, "running_mean": ones * 0.2, "running_var": ones * 0.5}
        weights |= {f"{c.name}.weight": kernel} | {f"{c.name}_norm.{key}": value for key, value in norm.items()}
    return weights


def test_the_onnx_file_answers_at_every_size() -> None:
    pytest.importorskip("onnx")
    from benchmarks.deep.onnx_file import resized, to_onnx

    written = to_onnx(made_weights(), (160, 96))
    for size, network in (((160, 96), written), ((96, 64), resized(written, (96, 64)))):
        net = cv2.dnn.readNetFromONNX(np.frombuffer(network, np.uint8))
        net.setInput(np.zeros((1, 3, size[1], size[0]), np.float32))
        answer = np.asarray(net.forward())
        columns, rows = size[0] // STRIDE, size[1] // STRIDE
        assert answer.shape == (1, 5, columns * rows)
        x = np.tile((np.arange(columns) + 0.5) * STRIDE, rows)
        y = np.repeat((np.arange(rows) + 0.5) * STRIDE, columns)
        np.testing.assert_allclose(answer[0, :2], [x, y], atol=1e-3)
        np.testing.assert_allclose(answer[0, 2:4], np.tile([[40.0], [24.0]], (1, columns * rows)), rtol=1e-4)
        np.testing.assert_allclose(answer[0, 4], 0.9, atol=1e-5)


def test_the_plug_in_runs_it() -> None:
    pytest.importorskip("onnx")
    from benchmarks.deep.onnx_file import to_onnx

    detector = OnnxDetector(to_onnx(made_weights(), (96, 64)), (96, 64), params=DetectorParams(keep_score=0.0))
    found = detector.detect(np.zeros((64, 96, 3), np.uint8))
    inside = found.boxes[(found.boxes[:, 0] > 0) & (found.boxes[:, 2] < 96) & (found.boxes[:, 1] > 0)]
    np.testing.assert_allclose(inside[:, 2] - inside[:, 0], 40, rtol=1e-3)
    assert len(inside)
    np.testing.assert_allclose(found.raw_scores, np.log(9), atol=1e-3)


def test_other_sizes_are_refused() -> None:
    pytest.importorskip("onnx")
    from benchmarks.deep.onnx_file import to_onnx

    with pytest.raises(ValueError, match=r"multiples of 32 px. Got 720x576"):
        to_onnx(made_weights(), (720, 576))


def test_pytorch_and_onnx_agree() -> None:
    torch = pytest.importorskip("torch")
    pytest.importorskip("onnx")
    from benchmarks.deep.loss import corners
    from benchmarks.deep.network import SignNetwork
    from benchmarks.deep.onnx_file import to_onnx

    torch.manual_seed(0)
    network = SignNetwork()
    network(torch.rand(2, 3, 64, 96))
    network.eval()
    picture = torch.rand(1, 3, 64, 96)
    with torch.no_grad():
        answer = network(picture)
        boxes = corners(answer[:, 1:])[0].reshape(4, -1).numpy()
    weights = {name: value.numpy() for name, value in network.state_dict().items()}
    net = cv2.dnn.readNetFromONNX(np.frombuffer(to_onnx(weights, (96, 64)), np.uint8))
    net.setInput(picture.numpy())
    found = np.asarray(net.forward())[0]
    np.testing.assert_allclose(found[:2] - found[2:4] / 2, boxes[:2], atol=1e-2)
    np.testing.assert_allclose(found[:2] + found[2:4] / 2, boxes[2:], atol=1e-2)
    np.testing.assert_allclose(found[4], torch.sigmoid(answer[0, 0]).numpy().ravel(), atol=1e-4)


def test_the_committed_network_matches_its_description() -> None:
    if not contenders.SIGNS.is_file():
        pytest.skip("no trained network lies in benchmarks/deep")
    content = contenders.SIGNS.read_bytes()
    reported = json.loads(contenders.SIGNS.with_suffix(".json").read_text(encoding="utf-8"))
    assert len(content) == reported["bytes"] < 2_000_000
    detector = OnnxDetector(content, tuple(reported["input"]), reported["layout"])
    assert len(detector.detect(np.full((800, 1360, 3), 90, np.uint8))) < 5  # a grey wall holds no signs


def test_missing_parts_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "00000.jpg").write_bytes(cv2.imencode(".jpg", np.zeros((40, 60, 3), np.uint8))[1].tobytes())
    (tmp_path / "gt.txt").write_text("00000.jpg;10;10;30;30;1\n")
    data = Data(tmp_path, None, None, None, tmp_path)
    monkeypatch.setattr(deep, "SIGNS", tmp_path / "none.onnx")
    with pytest.raises(Skip, match=r"no trained network; `python -m benchmarks\.deep\.train"):
        deep.EXPERIMENT.run(data)
    with pytest.raises(Skip, match="`gtsdb`"):
        yolo_time.EXPERIMENT.run(Data(None, None, None, None, tmp_path))
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(Skip, match="`onnxruntime` is not installed"):
        yolo_time.EXPERIMENT.run(data)


def test_an_interpreter_without_ultralytics_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    python = tmp_path / "python"
    python.write_text("#!/bin/sh\necho 'No module named ultralytics' >&2\nexit 1\n")
    python.chmod(0o755)
    monkeypatch.setattr(contenders.sys, "executable", str(python))
    monkeypatch.delenv("TSR_ORACLES", raising=False)
    with pytest.raises(Skip, match=r"`ultralytics` could not build the network \(No module named ultralytics\)"):
        contenders.yolo_networks(None, tmp_path / "yolo")


def test_a_left_out_network_is_named_in_the_report(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(contenders, "SIGNS", ROOT / "deep" / "none.onnx")
    with pytest.raises(Skip, match=r"no trained network at `benchmarks/deep/none\.onnx`"):
        contenders.deep_networks(None)
    monkeypatch.undo()
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(Skip, match="`onnx` is not installed"):
        contenders.deep_networks(None)
    result = Result.load(ROOT / "results" / "yolo_time.json")
    result.figures["left_out"] = {"the small deep detector": "`onnx` is away."}
    assert "*Skipped:* the small deep detector: `onnx` is away." in yolo_time.EXPERIMENT.report(result)
