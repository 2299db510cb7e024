"""The uncertainty of a track and its reasons in plain sentences; the queue sorts by it. Formulas: docs/queue.md."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.evidence.tables import FloatColumn, IntColumn

__all__ = ["Disagreement", "Uncertainties", "UncertaintyInput", "uncertainties"]

CLEAR_MARGIN = 0.6
"""A lead of the class over the runner-up, as a share of all votes, that counts as certain."""
CLEAR_RATIO = 3.0
"""A factor between L_positive and tau that counts as certain about the verdict."""
OFTEN_NEAR = 0.25
"""A share of verdicts within that factor of tau that is as uncertain as near verdicts can make a track."""
FEW_FRAMES, MANY_FRAMES = 3, 15
"""A track this short is as uncertain as a short track can be; this long, not at all."""
MANY_PREDICTED = 0.6
"""A share of frames without a measurement that is as uncertain as predictions can make a track."""
MOST = {"margin": 1.0, "gate": 0.5, "short": 0.7, "predicted": 0.6, "disagreement": 1.0}
"""What each reason can add at most."""
REPORTED = 0.1
"""A reason below this weight is not told."""


@dataclass(frozen=True, slots=True)
class Disagreement:
    """What another view of the video says of each track.

    Attributes:
        weight: shape (n,), 0 agrees or says nothing, 1 contradicts.
        sentence: one a track, empty where it agrees.
    """

    weight: FloatColumn
    sentence: list[str]


@dataclass(frozen=True, slots=True)
class UncertaintyInput:
    """What uncertainty is computed from; one entry a track.

    Attributes:
        frames: number of frames.
        predicted: frames whose result is the motion model's alone.
        name: what people read for its label, None: never recognised.
        share: its share of all votes; NaN: never recognised.
        runner_up: the same for the label with the second most votes, None: none.
        runner_up_share: its share.
        closest: smallest ``|ln(L_positive / tau)|``; infinite: never judged near tau.
        closest_frame: where; -1: nowhere.
        closest_value: L_positive there.
        near: verdicts with L_positive within a factor ``CLEAR_RATIO`` of tau.
        judged: all verdicts.
        tau: of the run.
    """

    frames: IntColumn
    predicted: IntColumn
    name: list[str | None]
    share: FloatColumn
    runner_up: list[str | None]
    runner_up_share: FloatColumn
    closest: FloatColumn
    closest_frame: IntColumn
    closest_value: FloatColumn
    near: IntColumn
    judged: IntColumn
    tau: float


@dataclass(frozen=True, slots=True)
class Uncertainties:
    """One entry a track."""

    uncertainty: FloatColumn
    """In [0, 1]."""
    reasons: list[list[str]]
    """Sentences, the weightiest first."""


def uncertainties(given: UncertaintyInput, disagreements: list[Disagreement]) -> Uncertainties:
    """Uncertainty and its reasons.

    Each reason has a weight in [0, 1], 0 where there is no uncertainty; together they are ``1 - product of (1 -
    weight)``, so that a further reason always adds and no reason is averaged away.
    """
    weights: list[FloatColumn] = [
        MOST["margin"] * _margin(given),
        MOST["gate"] * _gate(given),
        MOST["short"] * np.clip((MANY_FRAMES - given.frames) / (MANY_FRAMES - FEW_FRAMES), 0, 1),
        MOST["predicted"] * np.clip(given.predicted / np.maximum(given.frames, 1) / MANY_PREDICTED, 0, 1),
    ]
    tellers: list[Callable[[int], str]] = [
        lambda i: _margin_sentence(given, i),
        lambda i: _gate_sentence(given, i),
        lambda i: f"It is short: {_frames(int(given.frames[i]))}.",
        lambda i: (
            f"{int(given.predicted[i])} of its {_frames(int(given.frames[i]))} "
            f"{'is a prediction' if given.predicted[i] == 1 else 'are predictions'} without a measurement."
        ),
    ]
    for other in disagreements:
        weights.append(MOST["disagreement"] * np.clip(other.weight, 0, 1))
        tellers.append(other.sentence.__getitem__)
    table = np.stack(weights)
    together = 1 - np.prod(1 - table, axis=0)
    order = np.argsort(-table, axis=0, kind="stable")
    reported = table >= REPORTED
    reasons = [[tellers[k](i) for k in order[:, i] if reported[k, i]] for i in range(table.shape[1])]
    return Uncertainties(np.round(together, 4), reasons)


def _margin(given: UncertaintyInput) -> FloatColumn:
    lead = given.share - np.nan_to_num(given.runner_up_share)
    found: FloatColumn = np.where(np.isnan(given.share), 1.0, np.clip(1 - lead / CLEAR_MARGIN, 0, 1))
    return found


def _gate(given: UncertaintyInput) -> FloatColumn:
    """How close the closest verdict came, times how often one came near: in a long track some verdict always does."""
    closest = np.clip(1 - given.closest / np.log(CLEAR_RATIO), 0, 1)
    often: FloatColumn = np.clip(given.near / np.maximum(given.judged, 1) / OFTEN_NEAR, 0, 1)
    return np.asarray(closest * often)


def _margin_sentence(given: UncertaintyInput, i: int) -> str:
    if given.name[i] is None:
        return "It was never recognised."
    own = f"'{given.name[i]}' has {given.share[i]:.0%} of the votes"
    if given.runner_up[i] is None:
        return f"{own}."
    return f"{own}, '{given.runner_up[i]}' {given.runner_up_share[i]:.0%}."


def _gate_sentence(given: UncertaintyInput, i: int) -> str:
    return (
        f"{int(given.near[i])} of {int(given.judged[i])} verdicts of the gate were close, the closest in frame "
        f"{int(given.closest_frame[i])}: L = {given.closest_value[i]:.1f} beside tau = {given.tau:g}."
    )


def _frames(number: int) -> str:
    return "1 frame" if number == 1 else f"{number} frames"
