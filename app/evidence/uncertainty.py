"""Probability that a person changes a track, with reasons as sentences; the queue sorts by it. See docs/queue.md.

It is a logistic regression over the evidence of the track. ``python -m benchmarks uncertainty`` fits the weights on
tracks of annotated clips and simulated approaches that are compared with ground truth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from app.evidence.run_columns import FloatColumn, IntColumn
from tsr_engine.plural import plural

FEW_FRAMES, MANY_FRAMES = 3, 15
"""Lengths of a track, frames, at which its shortness counts in full and not at all."""
WEIGHTS: Final[Mapping[str, float]] = {
    "constant": -4.85, "margin": 2.85, "rejected": 1.25, "gaps": 2.95, "short": 1.68, "windows": 3.11,
}  # fmt: skip
"""Weights of the terms of :func:`terms`. Each term is 0 for a track with no evidence against it, and at most 1."""
MIN_REPORTED = 0.5
"""Minimum that a reason adds to the log-odds to be listed; the strongest is listed too if all together add as much."""
IMPORTED = "The run was imported, so it has no votes, gate verdicts and detections."


@dataclass(frozen=True, slots=True)
class Disagreement:
    """Differences of another run on each track.

    Attributes:
        weight: shape (n,), 0: it agrees or says nothing, 1: it contradicts, in between: it does not have the track.
        sentence: one per track, empty if it agrees.
    """

    weight: FloatColumn
    sentence: list[str]


@dataclass(frozen=True, slots=True)
class UncertaintyInput:
    """Input of the uncertainty; one entry per track.

    Attributes:
        frames: number of frames.
        detected: number of frames with a detection.
        name: displayed name of its label; None: not classified.
        share: the label's share of all votes; NaN: not classified.
        runner_up: displayed name of the label with the second most votes; None: there is none.
        runner_up_share: its share.
        rejected: number of verdicts of the gate that rejected the prediction.
        judged: number of all verdicts.
        windows: whether the run measures a rejected prediction at a relocalised window, which has a fixed size, as the
            preset ``paper`` does.
        by_engine: whether the run has evidence of the engine; a run that was imported from another tracker has none.
    """

    frames: IntColumn
    detected: IntColumn
    name: list[str | None]
    share: FloatColumn
    runner_up: list[str | None]
    runner_up_share: FloatColumn
    rejected: IntColumn
    judged: IntColumn
    windows: bool
    by_engine: bool


@dataclass(frozen=True, slots=True)
class Uncertainties:
    """Results; one entry per track."""

    uncertainty: FloatColumn
    """Probability that a person changes the track, in (0, 1); NaN: unknown."""
    rank: FloatColumn
    """Sort key of the queue, in [0, 1]."""
    reasons: list[list[str]]
    """Reasons as sentences, strongest first."""


def terms(inputs: UncertaintyInput) -> dict[str, FloatColumn]:
    """Compute the terms of the logistic regression by name, each of shape (n,)."""
    lead = np.nan_to_num(inputs.share) - np.nan_to_num(inputs.runner_up_share)
    return {
        "margin": np.clip(1 - lead, 0, 1),
        "rejected": np.clip(inputs.rejected / np.maximum(inputs.judged, 1), 0, 1),
        "gaps": np.clip(1 - inputs.detected / np.maximum(inputs.frames, 1), 0, 1),
        "short": np.clip((MANY_FRAMES - inputs.frames) / (MANY_FRAMES - FEW_FRAMES), 0, 1),
        "windows": np.full(len(inputs.frames), float(inputs.windows)),
    }


def uncertainties(inputs: UncertaintyInput, other: Disagreement | None) -> Uncertainties:
    """Compute uncertainty, order and reasons.

    Differences of another run are listed last and do not change the uncertainty: on the tracks that the weights are
    fitted on they do not predict changes. They alone order the tracks of a run without evidence.

    Args:
        inputs: input for each track.
        other: differences of another run of the video; None: there is none.
    """
    n = len(inputs.frames)
    other_reasons = [""] * n if other is None else other.sentence
    if not inputs.by_engine:
        rank = np.zeros(n) if other is None else other.weight
        return Uncertainties(
            np.full(n, np.nan),
            rank,
            [[*([other_reason] if other_reason else []), IMPORTED] for other_reason in other_reasons],
        )
    values = terms(inputs)
    added = np.stack([WEIGHTS[name] * values[name] for name in _SENTENCES])  # the run is no reason against one track
    base = WEIGHTS["constant"] + WEIGHTS["windows"] * values["windows"]
    uncertainty = np.round(1 / (1 + np.exp(-base - added.sum(axis=0))), 4)
    order = np.argsort(-added, axis=0, kind="stable")
    sentences = [*_SENTENCES.values()]
    reported = np.sort(-added, axis=0) <= -MIN_REPORTED
    reported[0] |= added.sum(axis=0) >= MIN_REPORTED
    reasons = [
        [sentences[k](inputs, i) for k in order[reported[:, i], i].tolist()] + ([other_reason] if other_reason else [])
        for i, other_reason in enumerate(other_reasons)
    ]
    return Uncertainties(uncertainty, uncertainty, reasons)


def _margin_sentence(inputs: UncertaintyInput, i: int) -> str:
    if inputs.name[i] is None:
        return "It was never recognised."
    winner = f"'{inputs.name[i]}' has {100 * inputs.share[i]:.0f} % of the votes"
    if inputs.runner_up[i] is None:
        return f"{winner}."
    return f"{winner}, '{inputs.runner_up[i]}' {100 * inputs.runner_up_share[i]:.0f} %."


def _rejected_sentence(inputs: UncertaintyInput, i: int) -> str:
    return f"The gate rejected its prediction in {int(inputs.rejected[i])} of {plural(int(inputs.judged[i]), 'frame')}."


def _gaps_sentence(inputs: UncertaintyInput, i: int) -> str:
    frames = int(inputs.frames[i])
    return f"No detection in {frames - int(inputs.detected[i])} of {plural(frames, 'frame')}."


def _short_sentence(inputs: UncertaintyInput, i: int) -> str:
    return f"It is short: {plural(int(inputs.frames[i]), 'frame')}."


_SENTENCES: Final[Mapping[str, Callable[[UncertaintyInput, int], str]]] = {
    "margin": _margin_sentence,
    "rejected": _rejected_sentence,
    "gaps": _gaps_sentence,
    "short": _short_sentence,
}
"""The terms that are reasons."""
