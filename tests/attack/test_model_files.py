"""Untrusted model files: arrays that would run code, and networks that name other files."""

from __future__ import annotations

import hashlib
import io
import json
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper

from tests.attack.damage import zipped
from tsr_engine.detection.onnx import OnnxDetector
from tsr_engine.detection.onnx_external_files import refers_to_files
from tsr_engine.errors import ModelError
from tsr_engine.io import models
from tsr_engine.io.models import load_component


class FileCreator:
    """Creates a file when it is unpickled."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.mark,)


def test_an_array_of_objects_is_refused_without_unpickling(tmp_path: Path) -> None:
    mark = tmp_path / "run"
    pickle.loads(pickle.dumps(FileCreator(mark)))
    assert mark.exists(), "the attack works where pickles are read"
    mark.unlink()
    out = io.BytesIO()
    np.savez(out, table=np.array([FileCreator(mark)], dtype=object))
    (tmp_path / "prior.npz").write_bytes(out.getvalue())
    entry = {"file": "prior.npz", "sha256": hashlib.sha256(out.getvalue()).hexdigest()}
    (tmp_path / "manifest.json").write_text(json.dumps({"format": 2, "components": {"prior": entry}}))
    with pytest.raises(ModelError, match="not a readable NumPy archive"):
        load_component("prior", tmp_path)
    assert not mark.exists()


def as_file(array: Any) -> bytes:
    out = io.BytesIO()
    np.save(out, array)
    return out.getvalue()


def array_claiming(count: int) -> bytes:
    """An array whose header states a far larger size."""
    head = as_file(np.zeros(8))
    return head.replace(b"(8,), }" + b" " * (len(str(count)) - 1), f"({count},), }}".encode())


def broken() -> bytes:
    """An archive with invalid compressed bytes."""
    whole = bytearray(zipped({"table.npy": as_file(np.arange(5000.0))}))
    at = whole.index(b"table.npy") + 40
    whole[at : at + 40] = b"\xff" * 40
    return bytes(whole)


NO_ARRAYS = {
    "says more than memory holds": lambda: zipped({"table.npy": array_claiming(10**14)}),
    "unfolds to more than is read": lambda: zipped({"table.npy": as_file(np.zeros(2**18))}),
    "cannot be unfolded": broken,
    "has a header that does not end": lambda: zipped({"table.npy": as_file(np.zeros(8)).replace(b"}", b" ")}),
    "no archive": lambda: b"PK\3\4" + bytes(30),
}


@pytest.mark.parametrize("content", NO_ARRAYS.values(), ids=NO_ARRAYS)
def test_an_invalid_or_too_large_archive_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, content: Callable[[], bytes]
) -> None:
    monkeypatch.setattr(models, "MAX_BYTES", 2**21)
    data = content()
    (tmp_path / "prior.npz").write_bytes(data)
    entry = {"file": "prior.npz", "sha256": hashlib.sha256(data).hexdigest()}
    (tmp_path / "manifest.json").write_text(json.dumps({"format": 2, "components": {"prior": entry}}))
    with pytest.raises(ModelError, match=r"prior\.npz (is not a readable NumPy archive|holds an array that)"):
        load_component("prior", tmp_path)


def outside(name: str = "w") -> TensorProto:
    tensor = TensorProto(name=name, data_type=TensorProto.FLOAT, dims=[3, 4], data_location=TensorProto.EXTERNAL)
    entry = tensor.external_data.add()
    entry.key, entry.value = "location", "secret.bin"
    return tensor


def network(kind: str) -> bytes:
    x, y = helper.make_tensor_value_info("x", 1, [1, 3]), helper.make_tensor_value_info("y", 1, [1, 4])
    inside = helper.make_tensor("w", 1, [3, 4], np.arange(12, dtype=np.float32))
    node = helper.make_node("MatMul", ["x", "w"], ["y"])
    if kind == "initializer":
        graph = helper.make_graph([node], "g", [x], [y], [outside()])
    elif kind == "constant":
        constant = helper.make_node("Constant", [], ["w"], value=outside())
        graph = helper.make_graph([constant, node], "g", [x], [y])
    elif kind == "branch":
        inner = helper.make_graph([helper.make_node("Identity", ["v"], ["z"])], "i", [], [y], [outside("v")])
        branch = helper.make_node("If", ["c"], ["w"], then_branch=inner, else_branch=inner)
        graph = helper.make_graph([branch, node], "g", [x], [y])
    else:
        graph = helper.make_graph([node], "g", [x], [y], [inside])
    return bytes(helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)]).SerializeToString())


@pytest.mark.parametrize("kind", ["initializer", "constant", "branch"])
def test_a_network_that_names_other_files_is_refused(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    np.arange(12, dtype=np.float32).tofile(tmp_path / "secret.bin")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match="weights lie in other files"):
        OnnxDetector(network(kind), (32, 32))


def test_a_network_in_one_file_is_accepted() -> None:
    assert not refers_to_files(network("plain"))
    assert onnx.load_model_from_string(network("plain")).graph.initializer


@pytest.mark.parametrize("content", [b"\x0a", b"\xff" * 30, b"\x3a\x7f", b"\x0b"])
def test_other_bytes_are_refused_as_a_network(content: bytes) -> None:
    with pytest.raises(ValueError, match="ONNX"):
        OnnxDetector(content, (32, 32))
