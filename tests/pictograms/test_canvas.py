"""The vector canvas: placed canvases, paths, texts."""

from __future__ import annotations

import numpy as np
import pytest

from tsr_engine.pictograms.canvas import Canvas
from tsr_engine.pictograms.glyphs import text_width, write
from tsr_engine.pictograms.letters import LETTERS
from tsr_engine.pictograms.paths import path
from tsr_engine.pictograms.plates import end_stripes, rectangle, slash

RED, BLUE = (200, 0, 0), (0, 0, 200)


def test_a_placed_canvas_moves_turns_mirrors_and_recolours() -> None:
    canvas = Canvas()
    canvas.outline(rectangle(1, 1, 0.01))
    corner = path("0 0 100 0 100 20 0 20")
    canvas.placed(0.5, 0.25, -0.5, mirror=True).fill(corner, RED)
    np.testing.assert_allclose(canvas.polygons()[0], path("25 -50 -25 -50 -25 -40 25 -40"))
    canvas.placed(1, turn=90).fill(corner, RED)
    np.testing.assert_allclose(canvas.polygons()[1], path("0 0 0 100 -20 100 -20 0"), atol=1e-12)
    canvas.placed(1, colours={RED: BLUE}).placed(0.5).fill(rectangle(1, 1), RED)
    assert canvas.picture(20)[10, 10].tolist() == [200, 0, 0, 255]


def test_a_placed_canvas_keeps_strokes_and_discs() -> None:
    canvas = Canvas()
    placed = canvas.placed(0.5)
    placed.stroke(path("-100 0 100 0"), 0.4, RED, caps=True)
    placed.disc(0, 0, 1, RED)
    assert len(canvas.polygons()) == 4
    assert max(np.abs(points).max() for points in canvas.polygons()) == pytest.approx(0.6, abs=0.01)


def test_paths_have_corners_and_curves() -> None:
    np.testing.assert_allclose(path("0 0 100 -50.5"), [(0, 0), (1, -0.505)])
    curve = path("0 0 Q 100 0 100 100 L 0 100")
    np.testing.assert_allclose(curve[[0, -2, -1]], [(0, 0), (1, 1), (0, 1)])
    np.testing.assert_allclose(curve[5], (0.75, 0.25))


@pytest.mark.parametrize("text", ["0 0 1", "0 0 Q 1 2 3", "0 0 1 L 2 3"])
def test_an_incomplete_path_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="numbers too many"):
        path(text)


@pytest.mark.parametrize("symbol", [*"0123456789STOP", *sorted(set(LETTERS) - {" "})])
def test_every_symbol_fills_its_width(symbol: str) -> None:
    canvas = Canvas()
    write(canvas, symbol, 1.0, 0, 0, RED)
    points = np.concatenate(canvas.polygons())
    assert np.abs(points[:, 0]).max() == pytest.approx(text_width(symbol) / 2, abs=0.1)
    assert np.abs(points[:, 1]).max() < 0.7


@pytest.mark.parametrize("size", [(0.98, 0.4), (0.5, 0.9)])
def test_bars_across_a_board_stay_on_it(size: tuple[float, float]) -> None:
    canvas = Canvas()
    slash(canvas, *size, 0.17, RED)
    for x, y in canvas.polygons()[0]:
        assert abs(x) <= size[0] + 1e-9
        assert abs(y) <= size[1] + 1e-9
    stripes = Canvas()
    end_stripes(stripes, *size)
    assert len(stripes.polygons()) == 3
    for polygon in stripes.polygons():
        assert np.all(np.abs(polygon) <= np.array(size) + 0.03)
        assert polygon[:, 0].min() < 0 < polygon[:, 0].max()
