"""Parameters and samples that IncrementalSVC refuses, and samples too far apart for doubles."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tsr_engine import IncrementalSVC


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"C": 0}, "'C' parameter of IncrementalSVC must be a number greater than 0 and at most 1e+12. Got 0 instead."),
        ({"C": 2e12, "kernel": "rbf"}, "at most 1e+12. Got 2000000000000.0 instead."),
        ({"C": float("nan")}, "'C' parameter"),
        ({"C": True}, "'C' parameter"),
        ({"kernel": "poly"}, "The 'kernel' parameter of IncrementalSVC must be 'linear' or 'rbf'. Got 'poly' instead."),
        ({"gamma": -1.0}, "'gamma' parameter"),
    ],
)
def test_bad_parameters(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match="parameter of IncrementalSVC") as caught:
        IncrementalSVC(**arguments)
    assert words in str(caught.value)


def test_bad_samples_leave_the_model_unchanged() -> None:
    model = IncrementalSVC().partial_fit([[0.0, 1.0], [1.0, 0.0]], [-1, 1])
    state = model.alpha_.tobytes()
    bad_samples: list[tuple[Any, list[int], str]] = [
        ([[1.0]], [1], "2 features"),
        ([[1.0, np.nan]], [1], "finite"),
        ([[1.0, 2.0]], [0], "-1 or \\+1"),
        ([[1.0, 2.0]], [1, 1], r"shape \(1,\)"),
        ([1.0, 2.0], [1], r"shape \(m, d\)"),
        ([["a", "b"]], [1], "numbers"),
        ([[0.0, 0.0], [1e6, 1e5]], [-1, 1], r"<= 1e\+12 with a linear kernel. Got 1.01e\+12 instead; scale"),
    ]
    for X, y, words in bad_samples:
        with pytest.raises(ValueError, match=words):
            model.partial_fit(X, y)
    bad_indices: list[tuple[Any, type[Exception]]] = [
        ([2], IndexError),
        ([-1], IndexError),
        ([0, 0], ValueError),
        ([0.5], ValueError),
    ]
    for indices, error in bad_indices:
        with pytest.raises(error, match="indices to unlearn"):
            model.unlearn(indices)
    assert model.alpha_.tobytes() == state
    with pytest.raises(IndexError, match="no samples to unlearn"):
        IncrementalSVC().unlearn([0])
    with pytest.raises(AttributeError, match="linear"):
        _ = IncrementalSVC(kernel="rbf").coef_


def test_samples_too_far_apart_for_doubles_have_kernel_zero() -> None:
    model = IncrementalSVC(C=1.0, kernel="rbf", gamma=2.0).partial_fit([[0.0, 0.0], [1e200, 0.0]], [1, -1])
    assert model.kkt_residual() < 1e-15
    assert model.decision_function([[0.0, 0.0], [1e200, 0.0], [-1e200, 1.0]]).tolist() == [1.0, -1.0, 0.0]
