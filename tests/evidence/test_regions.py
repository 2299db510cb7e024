"""Crops from stored rectangles equal crops from the frame."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsr_engine.errors import EvidenceError
from tsr_engine.evidence import FramePixels, StoredPixels
from tsr_engine.evidence.pixels import decode_pixels, encode_pixels
from tsr_engine.evidence.regions import merge
from tsr_engine.records import Region

W, H = 40, 30
PICTURE = np.random.default_rng(0).integers(0, 256, (H, W, 3), dtype=np.uint8)

corners = st.tuples(st.integers(-20, 60), st.integers(-20, 50), st.integers(0, 40), st.integers(0, 40))
requests = st.lists(corners.map(lambda r: (r[0], r[1], r[0] + r[2], r[1] + r[3])), max_size=8)


@given(requests, st.integers(0, 5))
def test_stored_crops_equal_live_crops(asked: list[tuple[int, int, int, int]], pad: int) -> None:
    live = FramePixels(PICTURE)
    crops = [live.crop(*r) for r in asked]
    stored = StoredPixels(W, H, live.regions(pad))
    for r, crop in zip(asked, crops, strict=True):
        again = stored.crop(*r)
        assert again.shape == crop.shape == (r[3] - r[1], r[2] - r[0], 3)
        assert (again == crop).all()
    assert stored.missing == 0


@given(requests)
def test_regions_cover_the_request_inside_the_picture(asked: list[tuple[int, int, int, int]]) -> None:
    live = FramePixels(PICTURE)
    covered = np.zeros((H, W), bool)
    for r in asked:
        live.crop(*r)
        if r[0] < r[2] and r[1] < r[3]:
            covered[max(0, r[1]) : max(0, r[3]), max(0, r[0]) : max(0, r[2])] = True
    stored = np.zeros((H, W), bool)
    for region in live.regions():
        h, w = region.pixels.shape[:2]
        assert 0 <= region.x < region.x + w <= W
        assert 0 <= region.y < region.y + h <= H
        assert (region.pixels == PICTURE[region.y : region.y + h, region.x : region.x + w]).all()
        stored[region.y : region.y + h, region.x : region.x + w] = True
    assert (stored | ~covered).all()


def test_the_border_is_replicated() -> None:
    padded = np.pad(PICTURE, ((25, 25), (25, 25), (0, 0)), mode="edge")
    live = FramePixels(PICTURE)
    for box in [(-5, -7, 4, 3), (35, 25, 50, 48), (-20, 5, -10, 9), (45, -20, 60, -10), (-25, -25, 65, 55)]:
        x1, y1, x2, y2 = box
        assert (live.crop(*box) == padded[y1 + 25 : y2 + 25, x1 + 25 : x2 + 25]).all()


def test_missing_pixels_come_from_the_nearest_stored_one_and_are_counted() -> None:
    first = Region(0, 0, np.full((10, 10, 3), 50, np.uint8))
    second = Region(20, 0, np.full((10, 10, 3), 90, np.uint8))
    stored = StoredPixels(W, H, [first, second])
    row = stored.crop(0, 5, 30, 6)[0, :, 0]
    assert row.tolist() == [50] * 15 + [90] * 15
    assert stored.missing == 10
    stored.crop(-5, 5, 12, 6)
    assert stored.missing == 12
    empty = StoredPixels(W, H, [])
    assert (empty.crop(0, 0, 4, 4) == 0).all()
    assert empty.missing == 16


def test_later_regions_overwrite() -> None:
    below, above = np.full((6, 6, 3), 1, np.uint8), np.full((3, 3, 3), 2, np.uint8)
    crop = StoredPixels(W, H, [Region(0, 0, below), Region(2, 2, above)]).crop(0, 0, 6, 6)
    assert (crop[2:5, 2:5] == 2).all()
    assert int((crop == 1).sum()) == (36 - 9) * 3


def test_overlapping_regions_are_merged() -> None:
    assert merge([(0, 0, 10, 10), (2, 2, 5, 5), (0, 0, 10, 10)]) == [(0, 0, 10, 10)]
    assert merge([(0, 0, 10, 10), (10, 0, 20, 10), (20, 0, 30, 10)]) == [(0, 0, 30, 10)]
    assert merge([(0, 0, 10, 10), (30, 20, 40, 30)]) == [(0, 0, 10, 10), (30, 20, 40, 30)]
    assert merge([]) == []


@given(st.integers(1, 20), st.integers(1, 20), st.integers(0, 2**32 - 1))
def test_pixel_coding_is_exact(width: int, height: int, seed: int) -> None:
    pixels = np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)
    assert (decode_pixels(encode_pixels(pixels), width, height) == pixels).all()


def test_pixel_coding_shrinks_smooth_pictures_and_names_damage() -> None:
    smooth = np.zeros((60, 60, 3), np.uint8)
    smooth += np.arange(60, dtype=np.uint8)[:, None, None]
    blob = encode_pixels(smooth)
    assert len(blob) < smooth.nbytes / 5
    for broken in (b"", b"\xff\xff", blob[:-20]):
        with pytest.raises(EvidenceError, match="damaged"):
            decode_pixels(broken, 60, 60)
    with pytest.raises(EvidenceError, match="expected 30 bytes"):
        decode_pixels(blob, 10, 1)
