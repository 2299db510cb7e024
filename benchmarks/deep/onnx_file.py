"""The network as an ONNX file that `OnnxDetector` runs (layout ``v8``, one class), for inputs of any size.

Batch normalisation is folded into the convolutions before it. Fixed operations at the end convert log-distances to
centre and size, so that the output is that of a YOLO network: ``(1, 5, cells)``. Needs `onnx`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

from benchmarks.deep.architecture import CONVOLUTIONS, MAX_STRIDE, STRIDE
from tsr_engine.json_shapes import JsonMapping

Array = NDArray[np.float32]
_EPSILON = 1e-5
"""Epsilon of PyTorch's batch normalisation."""
WRITTEN_SIZE = (1376, 800)
"""Input of the file that is kept, px: the smallest multiples of 32 over a scene of 1360x800."""


def folded(weights: Mapping[str, NDArray[np.generic]], name: str) -> tuple[Array, Array]:
    """Kernel and bias of a convolution that includes its batch normalisation."""
    kernel = weights[f"{name}.weight"].astype(np.float64)
    if f"{name}.bias" in weights:
        return kernel.astype(np.float32), weights[f"{name}.bias"].astype(np.float32)
    norm = {
        key: weights[f"{name}_norm.{key}"].astype(np.float64)
        for key in ("weight", "bias", "running_mean", "running_var")
    }
    gain = norm["weight"] / np.sqrt(norm["running_var"] + _EPSILON)
    bias = norm["bias"] - norm["running_mean"] * gain
    return (kernel * gain[:, None, None, None]).astype(np.float32), bias.astype(np.float32)


def grid(size: tuple[int, int]) -> dict[str, Array]:
    """Centres of the cells, px, as two summands of shape (1, 4, 1, w / 8) and (1, 4, h / 8, 1): x, y, 0, 0.

    Raises:
        ValueError: the sides are no multiples of 32 px.
    """
    if any(side % MAX_STRIDE or side < MAX_STRIDE for side in size):
        raise ValueError(f"Expected an input whose sides are multiples of {MAX_STRIDE} px. Got {size[0]}x{size[1]}.")
    columns, rows = np.zeros((1, 4, 1, size[0] // STRIDE)), np.zeros((1, 4, size[1] // STRIDE, 1))
    columns[0, 0, 0] = (np.arange(size[0] // STRIDE) + 0.5) * STRIDE
    rows[0, 1, :, 0] = (np.arange(size[1] // STRIDE) + 0.5) * STRIDE
    return {"columns": columns.astype(np.float32), "rows": rows.astype(np.float32)}


class _Graph:
    """Builds a graph; each method adds nodes and returns the name of their output."""

    def __init__(self, weights: Mapping[str, NDArray[np.generic]]) -> None:
        self.weights = weights
        self.nodes: list[onnx.NodeProto] = []
        self.constants: list[onnx.TensorProto] = []

    def constant(self, name: str, value: NDArray[np.generic]) -> str:
        self.constants.append(numpy_helper.from_array(value, name))
        return name

    def add(self, kind: str, *inputs: str, **attributes: Any) -> str:  # Any: make_node takes any
        name = f"v{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, list(inputs), [name], **attributes))
        return name

    def conv(self, name: str, x: str) -> str:
        c = CONVOLUTIONS[name]
        kernel, bias = folded(self.weights, name)
        inputs = x, self.constant(f"{name}_w", kernel), self.constant(f"{name}_b", bias)
        return self.add("Conv", *inputs, kernel_shape=[c.size] * 2, strides=[c.stride] * 2, pads=[c.size // 2] * 4)

    def relu(self, name: str, x: str) -> str:
        return self.add("Relu", self.conv(name, x))

    def block(self, name: str, x: str) -> str:
        return self.add("Relu", self.add("Add", x, self.conv(f"{name}_b", self.relu(f"{name}_a", x))))

    def twice(self, x: str) -> str:
        attributes = {"mode": "nearest", "coordinate_transformation_mode": "asymmetric", "nearest_mode": "floor"}
        return self.add("Resize", x, "", "twice", **attributes)

    def answer(self) -> str:
        """The convolutional part, as in `network.SignNetwork`."""
        self.constant("twice", np.array([1, 1, 2, 2], np.float32))
        x = self.relu("at4", self.relu("down4", self.relu("stem", "images")))
        at8 = self.block("at8_again", self.block("at8", self.relu("down8", x)))
        at16 = self.block("at16", self.relu("down16", at8))
        at32 = self.relu("at32", self.relu("down32", at16))
        back = self.add("Add", self.relu("side16", at16), self.twice(self.relu("side32", at32)))
        back = self.add("Add", self.relu("side8", at8), self.twice(back))
        return self.conv("answer", self.relu("head", self.relu("merge", back)))

    def boxes(self, answer: str) -> str:
        """Centre, size and probability of each cell."""
        half, whole = STRIDE / 2, float(STRIDE)
        # From left, top, right, bottom in cells to the centre's offset from the cell's centre, and the size, in px.
        turn = np.array(
            [[-half, 0, half, 0], [0, -half, 0, half], [whole, 0, whole, 0], [0, whole, 0, whole]], np.float32
        )
        split = self.constant("split", np.array([1, 4], np.int64))
        self.nodes.append(helper.make_node("Split", [answer, split], ["logit", "logs"], axis=1))
        turned = self.add(
            "Conv", self.add("Exp", "logs"), self.constant("turn", turn[:, :, None, None]), kernel_shape=[1, 1]
        )
        placed = self.add("Add", self.add("Add", turned, "columns"), "rows")
        joined = self.add("Concat", placed, self.add("Sigmoid", "logit"), axis=1)
        return self.add("Reshape", joined, self.constant("flat", np.array([1, 5, -1], np.int64)))


def to_onnx(weights: Mapping[str, NDArray[np.generic]], size: tuple[int, int] = WRITTEN_SIZE) -> bytes:
    """A file's content.

    Args:
        weights: those of `network.SignNetwork`, by their PyTorch names.
        size: (width, height) of the input, multiples of 32 px.

    Raises:
        ValueError: another size.
    """
    graph = _Graph(weights)
    for name, values in grid(size).items():
        graph.constant(name, values)
    found = graph.boxes(graph.answer())
    cells = (size[0] // STRIDE) * (size[1] // STRIDE)
    made = helper.make_graph(
        graph.nodes,
        "signs",
        [helper.make_tensor_value_info("images", TensorProto.FLOAT, [1, 3, size[1], size[0]])],
        [helper.make_tensor_value_info(found, TensorProto.FLOAT, [1, 5, cells])],
        graph.constants,
    )
    model = helper.make_model(made, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
    onnx.checker.check_model(model)
    return bytes(model.SerializeToString())


def resized(network: bytes, size: tuple[int, int]) -> bytes:
    """The same network for an input of another size; only the grid and the declared shapes differ.

    Raises:
        ValueError: the sides are no multiples of 32 px.
    """
    model = onnx.load_from_string(network)
    places = grid(size)
    for constant in model.graph.initializer:
        if constant.name in places:
            constant.CopyFrom(numpy_helper.from_array(places[constant.name], constant.name))
    shapes = ([1, 3, size[1], size[0]], [1, 5, (size[0] // STRIDE) * (size[1] // STRIDE)])
    for value, shape in zip((model.graph.input[0], model.graph.output[0]), shapes, strict=True):
        for dimension, length in zip(value.type.tensor_type.shape.dim, shape, strict=True):
            dimension.dim_value = length
    return bytes(model.SerializeToString())


def write_network(path: Path, weights: Mapping[str, NDArray[np.generic]], budget: JsonMapping) -> None:
    """Write the file and, beside it, what its training took."""
    path.parent.mkdir(parents=True, exist_ok=True)
    content = to_onnx(weights)
    path.write_bytes(content)
    about = {"input": list(WRITTEN_SIZE), "layout": "v8", "bytes": len(content), "training": dict(budget)}
    path.with_suffix(".json").write_text(json.dumps(about, indent=1, sort_keys=True) + "\n", encoding="utf-8")
