"""Field numbers in the page's messages to the viewer equal those in the SDK's descriptor."""

from __future__ import annotations

import mmap
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from app.page_files import static_folder
from app.recordings import viewer

FILES = ("rerun/v1alpha1/viewer_control.proto", "rerun/v1alpha1/common.proto")
LENGTH = 2
Descriptor = dict[str, dict[str, int]]


def varint(data: Any, at: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        byte = data[at]
        at += 1
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            return value, at


def fields(data: Any, at: int = 0, end: int | None = None) -> Iterator[tuple[int, Any]]:
    """Number and content of each field of a message; stops at an invalid position."""
    while end is None or at < end:
        tag, after = varint(data, at)
        number, kind = tag >> 3, tag & 7
        if kind == 0:
            value, at = varint(data, after)
            yield number, value
        elif kind == LENGTH:
            size, after = varint(data, after)
            at = after + size
            yield number, bytes(data[after:at])
        else:
            return


def file_descriptor(data: mmap.mmap, name: str) -> Iterator[bytes]:
    """The messages (``DescriptorProto``) of one file of the protocol, from the SDK's gRPC reflection data."""
    start = data.find(bytes([0x0A, len(name)]) + name.encode() + b"\x12")
    assert start >= 0, f"the SDK carries no descriptor of {name} any more"
    for index, (number, content) in enumerate(fields(data, start)):
        if number == 0 or number > 12 or (number == 1 and index):
            return  # the rest belongs to other files
        if number == 4:
            yield content


def numbers(message: bytes) -> tuple[str, dict[str, int]]:
    """Name of a message, and the number of each of its fields."""
    name, found = "", {}
    for number, content in fields(message, 0, len(message)):
        if number == 1:
            name = content.decode()
        elif number == 2:
            parts = dict(fields(content, 0, len(content)))
            found[parts[1].decode()] = parts[3]
    return name, found


@pytest.fixture(scope="module")
def descriptor() -> Descriptor:
    binary = viewer.viewer_binary()
    assert binary is not None
    with binary.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        return dict(numbers(message) for name in FILES for message in file_descriptor(data, name))


def numbers_of_page() -> Descriptor:
    """The numbers in ``protocol.js``."""
    text = (static_folder() / "js" / "views" / "recording" / "protocol.js").read_text(encoding="utf-8")
    found = re.findall(r"^  (\w+): Object\.freeze\(\{([^}]*)\}\),$", text, re.MULTILINE)
    return {name: {k: int(v) for k, v in re.findall(r"(\w+): (\d+)", inner)} for name, inner in found}


def test_every_number_equals_the_sdks(descriptor: Descriptor) -> None:
    said = numbers_of_page()
    assert len(said) == 5
    for message, entries in said.items():
        assert entries
        for field, number in entries.items():
            assert descriptor[message].get(field) == number, f"{message}.{field}"


def test_the_version_is_the_pinned_one() -> None:
    pins = re.findall(r'"(rerun-sdk[^"]*)"', (Path(__file__).parents[3] / "pyproject.toml").read_text(encoding="utf-8"))
    assert pins == ["rerun-sdk>=0.41.0,<0.42"]
