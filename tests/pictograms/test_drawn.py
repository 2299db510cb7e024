"""Drawings by name, as pictures and as SVG."""

from __future__ import annotations

import hashlib
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from tsr_engine.pictograms import draw, names, svg
from tsr_engine.pictograms.canvas import Canvas

SVG = "{http://www.w3.org/2000/svg}"


def test_the_43_are_drawn_as_ever() -> None:
    """The sample drives and the exact numbers of the tests rest on these bytes."""
    for size, wanted in ((16, "1c0596c2473999ba"), (48, "f9c62bbdabd16f7e"), (128, "f5b816e05276e67f")):
        drawn = hashlib.sha256(b"".join(draw(f"gtsrb/{number}", size).tobytes() for number in range(43)))
        assert drawn.hexdigest().startswith(wanted), size


@pytest.mark.parametrize("name", ["gtsrb/43", "gtsrb/-1", "gtsrb/014", "stop", "vienna/"])
def test_an_unknown_name_is_refused(name: str) -> None:
    for ask in (lambda: draw(name, 32), lambda: svg(name)):
        with pytest.raises(KeyError, match=name):
            ask()


def test_an_empty_picture_is_refused() -> None:
    with pytest.raises(ValueError, match="size must be at least 1"):
        draw("gtsrb/3", 0)


@pytest.mark.parametrize("name", names())
def test_svg_holds_the_drawing(name: str) -> None:
    root = ET.fromstring(svg(name))
    assert root.tag == f"{SVG}svg"
    assert root.get("viewBox") == "-1 -1 2 2"
    assert root.findall(f"{SVG}clipPath/{SVG}path")
    groups = root.findall(f"{SVG}g/{SVG}g")
    assert len({group.get("fill") for group in groups}) >= 2
    assert all(path.get("d", "").startswith("M") for group in groups for path in group)


def test_svg_keeps_order_colours_and_places() -> None:
    canvas = Canvas()
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float)
    canvas.outline(square)
    canvas.fill(square, (255, 0, 16))
    canvas.fill(square / 3, (0, 10, 255))
    assert canvas.svg() == (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="-1 -1 2 2" fill-rule="evenodd">'
        '<clipPath id="s"><path d="M-1,-1L1,-1L1,1L-1,1Z"/></clipPath><g clip-path="url(#s)">'
        '<g fill="#ff0010"><path d="M-1,-1L1,-1L1,1L-1,1Z"/></g>'
        '<g fill="#000aff"><path d="M-0.3333,-0.3333L0.3333,-0.3333L0.3333,0.3333L-0.3333,0.3333Z"/></g></g></svg>\n'
    )
