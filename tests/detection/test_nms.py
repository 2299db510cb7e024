import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tsr_engine.detection.nms import suppress
from tsr_engine.geometry.boxes import area, intersection


def test_by_hand() -> None:
    boxes = np.array([[0, 0, 10, 10], [1, 1, 11, 11], [20, 0, 30, 10], [2, 2, 6, 6.0]])
    kept = suppress(boxes, np.array([1.0, 3.0, 2.0, 0.5]), 0.5)
    assert kept.tolist() == [1, 2]
    assert suppress(boxes, np.array([1.0, 3.0, 2.0, 0.5]), 0.5, limit=1).tolist() == [1]
    assert suppress(np.zeros((0, 4)), np.zeros(0), 0.5).tolist() == []


def test_a_much_smaller_box_inside_another_can_be_kept() -> None:
    boxes = np.array([[0, 0, 10, 10], [1, 1, 7, 7], [1, 1, 9.5, 9.5], [1, 1, 6.5, 6.5]])
    scores = np.array([1.0, 3.0, 0.5, 0.2])
    assert suppress(boxes, scores, 0.5).tolist() == [1]
    assert suppress(boxes, scores, 0.5, nested=0.6).tolist() == [1, 0]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**30), st.integers(1, 30), st.floats(0.1, 0.9))
def test_kept_boxes_do_not_overlap_and_the_rest_do(seed: int, n: int, overlap: float) -> None:
    rng = np.random.default_rng(seed)
    corner = rng.uniform(0, 40, (n, 2))
    boxes = np.concatenate([corner, corner + rng.uniform(2, 30, (n, 2))], axis=1)
    scores = rng.integers(0, 5, n).astype(float)
    kept = suppress(boxes, scores, overlap)
    share = intersection(boxes, boxes) / np.minimum(area(boxes)[:, None], area(boxes)[None])
    assert (np.diff(scores[kept]) <= 0).all()
    for a in kept:
        assert all(share[a, b] <= overlap for b in kept if a != b)
    for gone in set(range(n)) - set(kept.tolist()):
        assert any(share[gone, k] > overlap and scores[k] >= scores[gone] for k in kept)
