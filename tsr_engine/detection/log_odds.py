"""Combines the scores of verifier, sign verifier and (in older models) cascade into log-odds of being a sign."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import Final

from tsr_engine.records import FloatArray


@dataclass(frozen=True, slots=True)
class LogOdds:
    """Logistic regression on the scores, fitted on scenes that none of their models was trained on.

    Attributes:
        verifier: weight of the verifier's score, >= 0.
        cascade: weight of the cascade's score, >= 0; 0 unless the model is of an earlier training.
        sign_verifier: weight of the sign verifier score, >= 0.
        offset: log-odds for three scores of 0.
    """

    verifier: float
    cascade: float
    sign_verifier: float
    offset: float

    def of(self, verifier: FloatArray, cascade: FloatArray, sign_verifier: FloatArray) -> FloatArray:
        """Log-odds of candidates; all arrays of shape (n,)."""
        return self.verifier * verifier + self.cascade * cascade + self.sign_verifier * sign_verifier + self.offset

    def scaled(self, factor: float, shift: float) -> LogOdds:
        """The regression whose log-odds are multiplied by ``factor`` and then shifted by ``shift``."""
        return LogOdds(
            factor * self.verifier, factor * self.cascade, factor * self.sign_verifier, factor * self.offset + shift
        )

    def to_list(self) -> list[float]:
        """The four numbers in the order of the attributes, as in a model's settings."""
        return list(astuple(self))


UNFITTED: Final = LogOdds(1.0, 0.0, 1.0, 0.0)
"""The sum of verifier score and sign verifier score, without calibration.

Used if the scenes do not hold both signs and other candidates, so that nothing can be fitted.
"""
