"""The plug-in runs a real network: one convolution that detects red."""

from typing import Literal

import numpy as np
import pytest

from tests.detection.random_inputs import INVALID_PICTURES
from tsr_engine.detection.onnx import OnnxDetector, decode, letterbox
from tsr_engine.params.detector import DetectorParams
from tsr_engine.params.tracking import TrackingParams
from tsr_engine.protocols import OfflineDetector
from tsr_engine.tracking.tracker import Tracker

onnx = pytest.importorskip("onnx")


def redness_network(size: int, cell: int, layout: str, less_green: bool = True) -> bytes:
    """Every cell answers its own square with the cell's red as confidence, by default minus green."""
    from onnx import TensorProto, helper, numpy_helper

    n = size // cell
    centres = (np.arange(n) + 0.5) * cell
    grid = np.stack([np.tile(centres, n), np.repeat(centres, n), np.full(n * n, cell), np.full(n * n, cell)])
    weights = np.zeros((1, 3, cell, cell), np.float32)
    weights[0, 0], weights[0, 1] = 1 / cell**2, -less_green / cell**2
    constants = [
        numpy_helper.from_array(weights, "w"),
        numpy_helper.from_array(grid[None].astype(np.float32), "grid"),
        numpy_helper.from_array(np.array([1, 1, n * n], np.int64), "shape"),
        numpy_helper.from_array(np.ones((1, 1, n * n), np.float32), "ones"),
    ]
    nodes = [
        helper.make_node("Conv", ["images", "w"], ["c"], strides=[cell, cell], kernel_shape=[cell, cell]),
        helper.make_node("Relu", ["c"], ["r"]),
        helper.make_node("Reshape", ["r", "shape"], ["flat"]),
    ]
    if layout == "v8":
        nodes.append(helper.make_node("Concat", ["grid", "flat"], ["out"], axis=1))
        shape = [1, 5, n * n]
    else:
        nodes.append(helper.make_node("Concat", ["grid", "flat", "ones"], ["joined"], axis=1))
        nodes.append(helper.make_node("Transpose", ["joined"], ["out"], perm=[0, 2, 1]))
        shape = [1, n * n, 6]
    graph = helper.make_graph(
        nodes,
        "redness",
        [helper.make_tensor_value_info("images", TensorProto.FLOAT, [1, 3, size, size])],
        [helper.make_tensor_value_info("out", TensorProto.FLOAT, shape)],
        constants,
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
    return model.SerializeToString()


@pytest.mark.parametrize("layout", ["v8", "v5"])
def test_a_network_detects_red_squares(layout: str) -> None:
    detector = OnnxDetector(redness_network(128, 16, layout), (128, 128), layout, params=DetectorParams(keep_score=0.0))
    assert isinstance(detector, OfflineDetector)
    picture = np.full((128, 256, 3), 40, np.uint8)
    picture[32:64, 96:128] = (20, 20, 250)  # a cell of the letterboxed input, which is half the size
    found = detector.detect(picture)
    assert len(found) == 1
    np.testing.assert_allclose(found.boxes[0], [96, 32, 128, 64], atol=1.0)
    assert found.scores[0] == found.raw_scores[0] > 1.5


@pytest.mark.parametrize("height", [128, 132])
def test_detections_in_the_letterbox_bars_are_left_out(height: int) -> None:
    """The bars are red enough; their cells reach 0 or 2 px into the picture."""
    network = redness_network(128, 16, "v8", less_green=False)
    detector = OnnxDetector(network, (128, 128), "v8", params=DetectorParams(keep_score=-0.5))
    picture = np.full((height, 256, 3), 20, np.uint8)
    picture[64:96, 96:128] = (20, 20, 250)
    found = detector.detect(picture)
    assert len(found) == 1
    tracker = Tracker(TrackingParams(), 256, height)
    assert [len(tracker.step(frame, found).tracks) for frame in range(3)] == [1, 1, 1]


@pytest.mark.parametrize("wrong", INVALID_PICTURES)
def test_invalid_pictures_are_refused_with_their_shape(wrong: str) -> None:
    detector = OnnxDetector(redness_network(64, 16, "v8"), (64, 64))
    with pytest.raises(ValueError, match="A picture must") as refused:
        detector.detect(INVALID_PICTURES[wrong])
    assert str(INVALID_PICTURES[wrong].shape) in str(refused.value)


def test_letterbox_and_back() -> None:
    canvas, scale, offset = letterbox(np.zeros((100, 400, 3), np.uint8), (200, 200))
    assert (scale, offset) == (0.5, (0.0, 75.0))
    assert canvas[:75].min() == 114
    assert canvas[75:125].max() == 0


@pytest.mark.parametrize("layout", ["v8", "v5"])
@pytest.mark.parametrize("odd", [np.nan, np.inf, -np.inf])
def test_rows_that_are_not_finite_are_left_out(layout: Literal["v8", "v5"], odd: float) -> None:
    rows = np.tile(np.array([20, 30, 10, 10, 0.5, 0.5], np.float32), (12, 1))
    for column in range(rows.shape[1]):
        rows[column + 2, column] = odd
    boxes, confidence = decode((rows.T if layout == "v8" else rows)[None], layout)
    assert boxes.tolist() == [[15, 25, 25, 35]] * 6
    assert confidence.tolist() == [0.5 if layout == "v8" else 0.25] * 6


def test_other_outputs_and_files_are_refused() -> None:
    with pytest.raises(ValueError, match="one picture and at least one class"):
        decode(np.zeros((2, 5, 10), np.float32), "v8")
    with pytest.raises(ValueError, match="ONNX network that OpenCV reads"):
        OnnxDetector(b"not a network", (64, 64))
