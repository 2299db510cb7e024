"""How likely a person changes a track, with reasons in plain sentences; the queue sorts by it. See docs/queue.md.

A logistic regression over the evidence of the track. The weights come from ``python -m benchmarks uncertainty``, which
measures tracks of annotated clips and simulated approaches against ground truth.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from app.evidence.tables import FloatColumn, IntColumn
from tsr_engine.counted import counted

__all__ = ["WEIGHTS", "Disagreement", "Uncertainties", "UncertaintyInput", "terms", "uncertainties"]

FEW_FRAMES, MANY_FRAMES = 3, 15
"""A track this short is as uncertain as a short track can be; this long, not at all."""
WEIGHTS: Final[Mapping[str, float]] = {"constant": -4.33, "margin": 3.48, "rejected": 4.21, "gaps": 1.21, "short": 2.00}
"""Of the terms of :func:`terms`. Each of these is 0 for a track that nothing speaks against, and 1 at most."""
REPORTED = 0.5
"""A reason that adds less than this to the log-odds is told only if it is the weightiest and all add as much."""
IMPORTED = "The run was imported, so nothing is known of votes, gate and detections."


@dataclass(frozen=True, slots=True)
class Disagreement:
    """What another view of the video says of each track.

    Attributes:
        weight: shape (n,), 0 agrees or says nothing, 1 contradicts, between them: does not have the track.
        sentence: one a track, empty where it agrees.
    """

    weight: FloatColumn
    sentence: list[str]


@dataclass(frozen=True, slots=True)
class UncertaintyInput:
    """What uncertainty is computed from; one entry a track.

    Attributes:
        frames: number of frames.
        detected: frames with a detection.
        name: what people read for its label, None: never recognised.
        share: its share of all votes; NaN: never recognised.
        runner_up: the same for the label with the second most votes, None: none.
        runner_up_share: its share.
        rejected: verdicts of the gate that rejected the prediction.
        judged: all verdicts.
        by_engine: the run has evidence of the engine; a run that was imported from another tracker has none.
    """

    frames: IntColumn
    detected: IntColumn
    name: list[str | None]
    share: FloatColumn
    runner_up: list[str | None]
    runner_up_share: FloatColumn
    rejected: IntColumn
    judged: IntColumn
    by_engine: bool


@dataclass(frozen=True, slots=True)
class Uncertainties:
    """One entry a track."""

    uncertainty: FloatColumn
    """Probability that a person changes the track, in (0, 1); NaN: nothing is known."""
    rank: FloatColumn
    """What the queue sorts by, in [0, 1]."""
    reasons: list[list[str]]
    """Sentences, the weightiest first."""


def terms(given: UncertaintyInput) -> dict[str, FloatColumn]:
    """The terms of the logistic by name, each of shape (n,)."""
    lead = np.nan_to_num(given.share) - np.nan_to_num(given.runner_up_share)
    return {
        "margin": np.clip(1 - lead, 0, 1),
        "rejected": np.clip(given.rejected / np.maximum(given.judged, 1), 0, 1),
        "gaps": np.clip(1 - given.detected / np.maximum(given.frames, 1), 0, 1),
        "short": np.clip((MANY_FRAMES - given.frames) / (MANY_FRAMES - FEW_FRAMES), 0, 1),
    }


def uncertainties(given: UncertaintyInput, other: Disagreement | None) -> Uncertainties:
    """Uncertainty, order and reasons.

    What another run says otherwise is told last and moves nothing: on the tracks that the weights come from it says
    nothing of what a person changes. It alone orders the tracks of a run without evidence.

    Args:
        given: of each track.
        other: what another run of the video says; None: there is none.
    """
    n = len(given.frames)
    said = [""] * n if other is None else other.sentence
    if not given.by_engine:
        rank = np.zeros(n) if other is None else other.weight
        return Uncertainties(np.full(n, np.nan), rank, [[*([one] if one else []), IMPORTED] for one in said])
    added = np.stack([WEIGHTS[name] * term for name, term in terms(given).items()])
    uncertainty = np.round(1 / (1 + np.exp(-WEIGHTS["constant"] - added.sum(axis=0))), 4)
    order = np.argsort(-added, axis=0, kind="stable")
    tellers = [_margin_sentence, _rejected_sentence, _gaps_sentence, _short_sentence]
    told = np.sort(-added, axis=0) <= -REPORTED
    told[0] |= added.sum(axis=0) >= REPORTED
    reasons = [
        [tellers[k](given, i) for k in order[told[:, i], i].tolist()] + ([one] if one else [])
        for i, one in enumerate(said)
    ]
    return Uncertainties(uncertainty, uncertainty, reasons)


def _margin_sentence(given: UncertaintyInput, i: int) -> str:
    if given.name[i] is None:
        return "It was never recognised."
    own = f"'{given.name[i]}' has {given.share[i]:.0%} of the votes"
    if given.runner_up[i] is None:
        return f"{own}."
    return f"{own}, '{given.runner_up[i]}' {given.runner_up_share[i]:.0%}."


def _rejected_sentence(given: UncertaintyInput, i: int) -> str:
    return f"The gate rejected its prediction in {int(given.rejected[i])} of {counted(int(given.judged[i]), 'frame')}."


def _gaps_sentence(given: UncertaintyInput, i: int) -> str:
    frames = int(given.frames[i])
    return f"No detection in {frames - int(given.detected[i])} of {counted(frames, 'frame')}."


def _short_sentence(given: UncertaintyInput, i: int) -> str:
    return f"It is short: {counted(int(given.frames[i]), 'frame')}."
