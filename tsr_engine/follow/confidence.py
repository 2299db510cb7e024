"""The probability that a box lies on the sign: a logistic regression over all observations of a frame.

``python -m benchmarks.tuning.follow_confidence`` fits the weights. It follows signs of clips and approaches of the
tuning set, once unchanged and once with the sign painted over from some frame on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

MIN_KEPT_CONFIDENCE: Final = 0.55
"""Confidence below which a sign counts as hidden."""
MIN_LEARNED_CONFIDENCE: Final = 0.85
"""Confidence from which the sign's appearance is learned."""

WEIGHTS: Final = {
    "constant": 0.03,
    "similarity": 2.84,
    "anchor_likeness": 0.88,
    "away": -1.06,
    "grown": -0.24,
    "score": 3.33,
    "known": 0.71,
    "decision": 3.19,
}
"""Weights of the terms of :meth:`Evidence.terms`."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """Observations of a sign in one frame.

    Attributes:
        similarity: largest correlation with a template.
        anchor_similarity: largest correlation with an anchor's template.
        away: distance from the predicted place, in standard deviations.
        grown: difference from the predicted size, in standard deviations.
        decision: decision value of the track's own SVM; None: there is no SVM.
        score: log-odds of the detector; None: the detector does not know the shape, or cannot score the box.
    """

    similarity: float
    anchor_similarity: float
    away: float
    grown: float
    decision: float | None
    score: float | None

    def terms(self) -> dict[str, float]:
        """The terms of the logistic regression by name, each of the order of one."""
        return {
            "constant": 1.0,
            "similarity": self.similarity,
            "anchor_likeness": self.anchor_similarity,
            "away": min(self.away, 6.0),
            "grown": min(self.grown, 6.0),
            "score": 0.0 if self.score is None else min(max(self.score, -4.0), 8.0) / 8.0,
            "known": float(self.score is not None),
            "decision": 0.0 if self.decision is None else min(max(self.decision, -2.0), 2.0),
        }

    @property
    def confidence(self) -> float:
        """Probability that the box lies on the sign, in (0, 1)."""
        value = sum(WEIGHTS[name] * term for name, term in self.terms().items())
        return 1.0 / (1.0 + math.exp(-value))
