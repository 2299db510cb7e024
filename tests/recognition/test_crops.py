import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsr_engine.recognition.crops import crop_bounds, cut


def numbered(width: int, height: int) -> np.ndarray:
    y, x = np.mgrid[:height, :width]
    return np.stack([x, y, x + y], axis=-1).astype(np.uint8)


def test_the_margin_is_added_on_each_side() -> None:
    assert crop_bounds((20, 30, 40, 60), 0.1) == (18, 27, 42, 63)


def test_a_crop_inside_the_picture_has_its_pixels() -> None:
    picture = numbered(60, 50)
    crop = cut(picture, (10, 20, 30, 40), 0.1)
    assert crop.flags.c_contiguous
    np.testing.assert_array_equal(crop, picture[18:42, 8:32])


def test_beyond_the_picture_the_border_is_repeated() -> None:
    crop = cut(numbered(20, 20), (-2, 5, 8, 15), 0.0)
    assert crop.shape == (10, 10, 3)
    assert crop[0, :, 0].tolist() == [0, 0, 0, 1, 2, 3, 4, 5, 6, 7]


@settings(deadline=None, max_examples=40)
@given(st.tuples(*[st.floats(-30, 60)] * 2), st.tuples(*[st.floats(0.01, 60)] * 2), st.floats(0, 0.5))
def test_any_overlapping_box_gives_a_crop_of_its_size(corner: tuple, size: tuple, margin: float) -> None:
    box = (*corner, corner[0] + size[0], corner[1] + size[1])
    x1, y1, x2, y2 = crop_bounds(box, margin)
    picture = numbered(40, 30)
    if x1 < 40 and y1 < 30 and x2 > 0 and y2 > 0:
        assert cut(picture, box, margin).shape == (y2 - y1, x2 - x1, 3)
    else:
        with pytest.raises(ValueError, match="does not overlap"):
            cut(picture, box, margin)
