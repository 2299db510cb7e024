"""Finds the other files that an ONNX file refers to, without loading it.

A tensor may take its values from another file, by any path. OpenCV reads that file even if the network is given as
bytes, so a foreign network could read any file of this machine as its weights.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

_TENSOR: Final = "tensor"
_EXTERNAL: Final = (13, 14)
"""Fields of a tensor: the place of its external values, and the mark that values are external."""
_SUBMESSAGES: Final[dict[str, dict[int, str]]] = {
    "model": {7: "graph", 20: "training", 25: "function"},
    "graph": {1: "node", 5: _TENSOR, 15: "sparse"},
    "node": {5: "attribute"},
    "attribute": {5: _TENSOR, 6: "graph", 10: _TENSOR, 11: "graph", 22: "sparse", 23: "sparse"},
    "sparse": {1: _TENSOR, 2: _TENSOR},
    "function": {7: "node", 11: "attribute"},
    "training": {1: "graph", 2: "graph"},
}
"""Fields of onnx.proto that hold messages: message -> number of the field -> message."""
_MAX_DEPTH: Final = 64
_VARINT, _FIXED64, _BYTES, _FIXED32 = 0, 1, 2, 5


def refers_to_files(network: bytes) -> bool:
    """Whether the network takes values from other files.

    Raises:
        ValueError: the bytes are not a protocol-buffers message, or the message is cut short or nested too deeply.
    """
    return _has_external_values(memoryview(network), "model", 0)


def _has_external_values(data: memoryview, message: str, depth: int) -> bool:
    if depth > _MAX_DEPTH:
        raise ValueError("Expected an ONNX network that OpenCV reads. Got one that is nested too deeply.")
    if message == _TENSOR:
        return any(field in _EXTERNAL and value not in (0, b"") for field, value in _fields(data))
    parts = _SUBMESSAGES[message]
    return any(
        _has_external_values(value, parts[field], depth + 1)
        for field, value in _fields(data)
        if field in parts and isinstance(value, memoryview)
    )


def _fields(data: memoryview) -> Iterator[tuple[int, int | memoryview]]:
    """Number and value of each field."""
    offset = 0
    while offset < len(data):
        tag, offset = _varint(data, offset)
        kind = tag & 7
        if kind == _VARINT:
            number, offset = _varint(data, offset)
            yield tag >> 3, number
            continue
        if kind == _BYTES:
            size, offset = _varint(data, offset)
        elif kind in (_FIXED64, _FIXED32):
            size = 8 if kind == _FIXED64 else 4
        else:
            raise ValueError("Expected an ONNX network that OpenCV reads. Got bytes that are not a network.")
        if offset + size > len(data):
            raise ValueError("Expected an ONNX network that OpenCV reads. Got one that is cut short.")
        if kind == _BYTES:
            yield tag >> 3, data[offset : offset + size]
        offset += size


def _varint(data: memoryview, offset: int) -> tuple[int, int]:
    value = 0
    for shift in range(0, 70, 7):
        if offset >= len(data):
            break
        byte = data[offset]
        offset += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, offset
    raise ValueError("Expected an ONNX network that OpenCV reads. Got one that is cut short.")
