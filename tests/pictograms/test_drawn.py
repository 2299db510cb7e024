"""Drawings by name are complete and distinct, as pictures and as SVG."""

from __future__ import annotations

import hashlib
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from tsr_engine.pictograms import draw, names, svg
from tsr_engine.pictograms.canvas import Canvas

SVG = "{http://www.w3.org/2000/svg}"


def over_grey(name: str, size: int) -> np.ndarray:
    picture = draw(name, size).astype(np.float32)
    alpha = picture[..., 3:] / 255
    return np.asarray(picture[..., :3] * alpha + 128 * (1 - alpha))


def test_the_43_drawings_are_unchanged() -> None:
    """The sample drives and the exact numbers of the tests depend on these bytes."""
    for size, wanted in ((16, "1c0596c2473999ba"), (48, "f9c62bbdabd16f7e"), (128, "f5b816e05276e67f")):
        drawn = hashlib.sha256(b"".join(draw(f"gtsrb/{number}", size).tobytes() for number in range(43)))
        assert drawn.hexdigest().startswith(wanted), size


def test_no_two_drawings_are_alike() -> None:
    flat = np.array([over_grey(name, 48).ravel() for name in names()])
    for k, name in enumerate(names()):
        apart = np.abs(flat - flat[k]).mean(1)
        apart[k] = np.inf
        assert apart.min() > 0.4, (name, names()[int(apart.argmin())], apart.min())


@pytest.mark.parametrize("name", ["gtsrb/7", "vienna/no-parking", "vienna/cross-wind", "vienna/residential-area"])
@pytest.mark.parametrize("size", [1, 16, 333, 512])
def test_drawings_scale_to_any_size(name: str, size: int) -> None:
    picture = draw(name, size)
    assert picture.shape == (size, size, 4)
    assert picture.dtype == np.uint8
    assert picture.flags.c_contiguous
    np.testing.assert_array_equal(picture, draw(name, size))
    if size >= 16:
        assert picture[0, 0, 3] == 0
        assert picture[size // 2, size // 2, 3] == 255


@pytest.mark.parametrize("name", ["gtsrb/43", "gtsrb/-1", "gtsrb/014", "stop", "vienna/", "vienna/Stop", "vienna/14"])
def test_an_unknown_name_is_refused(name: str) -> None:
    for ask in (lambda: draw(name, 32), lambda: svg(name)):
        with pytest.raises(KeyError, match=name):
            ask()


def test_an_empty_picture_is_refused() -> None:
    with pytest.raises(ValueError, match="size must be at least 1"):
        draw("gtsrb/3", 0)


def test_svg_contains_every_drawing() -> None:
    for name in names():
        text = svg(name)
        root = ET.fromstring(text)
        assert root.tag == f"{SVG}svg", name
        assert root.findall(f"{SVG}clipPath/{SVG}path"), name
        groups = root.findall(f"{SVG}g/{SVG}g")
        assert len({group.get("fill") for group in groups}) >= 2, name
        assert all(path.get("d", "").startswith("M") for group in groups for path in group), name
        assert len(text) < 100_000, name


def test_svg_keeps_order_colours_and_places() -> None:
    canvas = Canvas()
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float)
    canvas.outline(square)
    canvas.fill(square, (255, 0, 16))
    canvas.fill(square / 3, (0, 10, 255))
    assert canvas.svg() == (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="-1000 -1000 2000 2000" fill-rule="evenodd">'
        '<clipPath id="s"><path d="M-1000,-1000L1000,-1000L1000,1000L-1000,1000Z"/></clipPath><g clip-path="url(#s)">'
        '<g fill="#ff0010"><path d="M-1000,-1000L1000,-1000L1000,1000L-1000,1000Z"/></g>'
        '<g fill="#000aff"><path d="M-333,-333L333,-333L333,333L-333,333Z"/></g></g></svg>\n'
    )
