from itertools import pairwise

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsr_engine.channels.interleaving import interleave
from tsr_engine.channels.pyramid import PyramidPlan, build_pyramid, level_scales, resample
from tsr_engine.channels.scratch import Scratch
from tsr_engine.channels.smooth import smooth
from tsr_engine.detection.window import Window
from tsr_engine.training.public.power_law import measure_lambdas


def natural(seed: int, height: int, width: int) -> np.ndarray:
    """A picture with the spectrum of natural pictures (amplitude 1/f) and some sharp shapes."""
    rng = np.random.default_rng(seed)
    fy, fx = np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width)[None]
    f = np.hypot(fy, fx)
    f[0, 0] = 1
    planes = []
    for _ in range(3):
        noise = np.fft.fft2(rng.normal(size=(height, width))) / f
        plane = np.real(np.fft.ifft2(noise))
        planes.append((plane - plane.min()) / np.ptp(plane) * 255)
    picture = np.stack(planes, -1).astype(np.uint8)
    for _ in range(12):
        x, y, r = int(rng.integers(width)), int(rng.integers(height)), int(rng.integers(6, 40))
        cv2.circle(picture, (x, y), r, tuple(int(v) for v in rng.integers(0, 255, 3)), -1, cv2.LINE_AA)
    return picture


def test_scales_descend_by_equal_steps() -> None:
    scales = level_scales(1.5, 0.1, 8)
    assert scales[0] == 1.5
    assert scales[-1] >= 0.1 > scales[-1] * 2 ** (-1 / 8)
    np.testing.assert_allclose(scales[:-1] / scales[1:], 2 ** (1 / 8))
    assert len(level_scales(0.1, 1.0, 8)) == 0


def test_computed_levels_equal_the_channels() -> None:
    picture = natural(0, 120, 160)
    plan = PyramidPlan(per_octave=4, computed_per_octave=4)
    for level in build_pyramid(picture, level_scales(1.5, 0.3, 4), plan):
        assert level.computed
        assert np.array_equal(level.gains, np.ones(10))
        assert level.cells.shape == (10, int(120 * level.scale_y) // 2, int(160 * level.scale_x) // 2)


def test_approximated_levels_stay_within_the_stated_error() -> None:
    """Mean error of an approximated byte: at most 6 of 255 for colour, 16 for gradients (two computed an octave)."""
    pictures = [natural(k, 240, 320) for k in range(3)]
    lambdas = measure_lambdas(pictures)
    scales = level_scales(1.5, 0.25, 8)
    fast = PyramidPlan(per_octave=8, computed_per_octave=2, lambdas=lambdas)
    exact = PyramidPlan(per_octave=8, computed_per_octave=8, lambdas=lambdas)
    colour, gradient = [], []
    for picture in pictures:
        pairs = zip(build_pyramid(picture, scales, fast), build_pyramid(picture, scales, exact), strict=True)
        for a, b in pairs:
            assert a.index == b.index
            if a.computed:
                continue
            rows, columns = min(a.cells.shape[1], b.cells.shape[1]), min(a.cells.shape[2], b.cells.shape[2])
            error = np.abs(
                a.with_gains(a.cells)[:, :rows, :columns].astype(int) - b.cells[:, :rows, :columns].astype(int)
            )
            colour.append(error[:3].mean())
            gradient.append(error[3:].mean())
    assert len(colour) > 20
    assert np.mean(colour) < 6
    assert np.mean(gradient) < 16


def test_the_power_law_reduces_the_error() -> None:
    pictures = [natural(k, 240, 320) for k in range(3)]
    lambdas = measure_lambdas(pictures)
    assert all(abs(v) < 0.02 for v in lambdas[:3])
    scales = level_scales(1.0, 0.5, 8)
    errors = {}
    for name, used in (("with", lambdas), ("without", (0.0,) * 10)):
        plan = PyramidPlan(per_octave=8, computed_per_octave=1, lambdas=used)
        exact = PyramidPlan(per_octave=8, computed_per_octave=8)
        bias = []
        for picture in pictures:
            for a, b in zip(build_pyramid(picture, scales, plan), build_pyramid(picture, scales, exact), strict=True):
                if not a.computed:
                    bias.append(abs(a.with_gains(a.cells)[3].mean() - b.cells[3].mean()))
        errors[name] = np.mean(bias)
    assert errors["with"] < errors["without"]


def test_bands_have_the_same_cells_as_the_whole() -> None:
    picture = natural(5, 200, 240)
    scales = level_scales(1.5, 0.4, 8)
    plan = PyramidPlan(per_octave=8, computed_per_octave=8)
    whole = list(build_pyramid(picture, scales, plan))
    part = list(build_pyramid(picture, scales, plan, [(60.0, 140.0)] * len(scales)))
    for a, b in zip(whole, part, strict=True):
        offset = round(b.top * b.scale_y / 2)
        # two cells at a cut edge see its replicated border
        low, high = max(offset + 4, int(60 * a.scale_y / 2)), int(140 * a.scale_y / 2)
        assert np.array_equal(a.cells[:, low:high], b.cells[:, low - offset : high - offset])
        assert b.cells.shape[1] < a.cells.shape[1]


@pytest.mark.parametrize("computed", [1, 2])
def test_chains_share_equal_levels(computed: int) -> None:
    picture = natural(6, 150, 200)
    scales, plan = level_scales(1.5, 0.2, 8), PyramidPlan(computed_per_octave=computed, lambdas=(0.1,) * 10)
    whole = {level.index: level.cells for level in build_pyramid(picture, scales, plan)}
    shared = {
        level.index: level.cells for chain in range(2) for level in build_pyramid(picture, scales, plan, None, chain, 2)
    }
    assert whole.keys() == shared.keys()
    assert sorted(whole) == list(range(len(scales)))
    for index, cells in whole.items():
        assert np.array_equal(cells, shared[index])


def test_a_window_maps_to_its_sign() -> None:
    window = Window()
    picture = np.full((300, 400, 3), 60, np.uint8)
    picture[100:148, 200:248] = (30, 30, 220)
    scales = level_scales(0.5, 0.5, 8)
    level = next(iter(build_pyramid(picture, scales, PyramidPlan(), border=window.pad)))
    row, column = (100 * 0.5 - window.margin) / 2 + window.pad, (200 * 0.5 - window.margin) / 2 + window.pad
    np.testing.assert_allclose(window.to_boxes([row], [column], level), [[200, 100, 248, 148]], atol=1e-9)
    features = window.gather([round(row)], [round(column)], level).reshape(10, 14, 14)
    assert features[1, 4:10, 4:10].min() > features[1, 0].max()


def test_resample_keeps_flat_channels_flat() -> None:
    cells = np.repeat(np.arange(10, dtype=np.uint8)[:, None, None] * 20, 30, 1).repeat(40, 2)
    out = resample(interleave(cells), 22, 33)
    assert out.shape == (10, 22, 33)
    assert np.array_equal(out[:, 0, 0], cells[:, 0, 0])
    assert (np.ptp(out, axis=(1, 2)) == 0).all()


@pytest.mark.parametrize("channels", [1, 3, 5, 10])
@pytest.mark.parametrize("size", [(22, 33), (63, 85), (7, 2)])
def test_packed_channels_are_resampled_as_each_alone(channels: int, size: tuple[int, int]) -> None:
    cells = np.random.default_rng(channels).integers(0, 256, (channels, 50, 68), dtype=np.uint8)
    out = resample(interleave(cells), *size, border=2)
    alone = [cv2.resize(plane, size[::-1], interpolation=cv2.INTER_LINEAR) for plane in cells]
    np.testing.assert_array_equal(out, [np.pad(plane, 2, mode="edge") for plane in alone])


def test_invalid_plans_are_refused() -> None:
    with pytest.raises(ValueError, match="multiple of computed_per_octave. Got 8 and 3"):
        PyramidPlan(per_octave=8, computed_per_octave=3)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**20), st.integers(1, 40), st.integers(1, 40), st.sampled_from([0, 1, 3]))
def test_smoothing_equals_opencv_to_the_bit(seed: int, height: int, width: int, border: int) -> None:
    cells = np.random.default_rng(seed).integers(0, 256, (3, height, width), dtype=np.uint8)
    wanted = [
        cv2.copyMakeBorder(
            cv2.GaussianBlur(plane, (3, 3), 0, borderType=cv2.BORDER_REPLICATE), *[border] * 4, cv2.BORDER_REPLICATE
        )
        for plane in cells
    ]
    assert np.array_equal(smooth(cells, border), wanted)


def test_reused_memory_changes_no_level() -> None:
    """Pictures of several sizes one after another."""
    plan, scratch = PyramidPlan(per_octave=6, computed_per_octave=2, lambdas=(0.1,) * 10), Scratch()
    for seed, (height, width) in enumerate([(120, 160), (200, 260), (90, 130), (200, 260)]):
        picture, scales = natural(seed, height, width), level_scales(1.5, 0.2, 6)
        count = 0
        again = build_pyramid(picture, scales, plan, border=2, scratch=scratch)
        for fresh, level in zip(build_pyramid(picture, scales, plan, border=2), again, strict=True):
            assert np.array_equal(fresh.cells, level.cells)
            assert (fresh.index, fresh.scale_x, fresh.scale_y) == (level.index, level.scale_x, level.scale_y)
            count += 1
        assert count == len(scales)


def test_levels_own_their_cells_unless_memory_is_given() -> None:
    picture, scales = natural(5, 120, 160), level_scales(1.0, 0.25, 4)
    kept = list(build_pyramid(picture, scales, PyramidPlan(per_octave=4, computed_per_octave=2)))
    copies = [level.cells.copy() for level in kept]
    list(build_pyramid(natural(6, 120, 160), scales, PyramidPlan(per_octave=4, computed_per_octave=2)))
    assert all(np.array_equal(level.cells, copy) for level, copy in zip(kept, copies, strict=True))
    assert not any(np.shares_memory(a.cells, b.cells) for a, b in pairwise(kept))
