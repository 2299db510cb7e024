"""The temperature of a classifier and the likelihood at it."""

from __future__ import annotations

import numpy as np
import pytest

from tsr_engine.training.public.classifier_figures import fit_temperature, negative_log_likelihood


def test_overconfident_margins_are_cooled() -> None:
    generator = np.random.default_rng(0)
    logits = generator.normal(0, 2, (4000, 43))
    p = np.exp(logits) / np.exp(logits).sum(1, keepdims=True)
    labels = np.array([generator.choice(43, p=row) for row in p])
    assert fit_temperature(5 * logits, labels) == pytest.approx(5, rel=0.1)


def test_likelihood_by_hand() -> None:
    margins = np.zeros((1, 43))
    margins[0, 3] = np.log(42.0)
    assert negative_log_likelihood(margins, np.array([3]), 1.0) == pytest.approx(np.log(2), rel=1e-6)
