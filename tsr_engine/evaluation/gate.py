"""The experiment behind tau (Fig. 8): the share of candidates that the gate collects correctly, over tau.

For a sign known up to frame k, the candidates in frame k + 1 are the sign's box, slightly misplaced copies of it, and
patches around it. The gate is correct if it is confident for the first two and not for the patches.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tsr_engine.gating import Gate, HashMemory
from tsr_engine.geometry.boxes import expand
from tsr_engine.params.gate import GateParams
from tsr_engine.records import FloatArray, GateVerdict, Picture
from tsr_engine.tracking.camera_shift import CameraShift

GroundTruth = Mapping[int, Mapping[int, FloatArray]]
"""Frame -> sign -> box, shape (4,)."""


@dataclass(frozen=True, slots=True)
class Candidates:
    """The candidates around each sign.

    Attributes:
        patches: number of background patches around the sign.
        nearest: smallest distance of a patch's centre from the sign's, in sides of the sign; 0.35 sideways is an IoU of
            0.48.
        farthest: largest such distance, in sides of the sign.
        copies: number of misplaced copies of the sign's box.
        misplaced: standard deviation of each edge of a copy, in sides: the error of a good prediction.
        smallest: least side of a sign, px.
        history: least number of earlier frames of the sign.
        every: step between the tried frames; their ordinals are multiples of it.
    """

    patches: int = 20
    nearest: float = 0.35
    farthest: float = 1.5
    copies: int = 3
    misplaced: float = 0.04
    smallest: float = 14.0
    history: int = 3
    every: int = 1


@dataclass(frozen=True, slots=True)
class Trial:
    """One judged candidate."""

    sign: int
    frame: int
    genuine: bool
    verdict: GateVerdict


@dataclass(frozen=True, slots=True)
class CollectionCurve:
    """Rates over tau, averaged over the signs so that long tracks do not dominate.

    Attributes:
        tau: shape (n,), ascending.
        genuine: shape (n,), share of the sign's boxes and their copies that are confident.
        patches: shape (n,), share of the patches that are not confident.
        correct: shape (n,), mean of both: the correct collection rate for equally many positives and negatives.
    """

    tau: FloatArray
    genuine: FloatArray
    patches: FloatArray
    correct: FloatArray

    @property
    def best_tau(self) -> float:
        """The tau with the best correct collection rate."""
        return float(self.tau[int(np.argmax(self.correct))])


def gate_trials(
    frames: Iterable[tuple[int, Picture]],
    truth: GroundTruth,
    params: GateParams,
    candidates: Candidates | None = None,
    seed: int = 0,
) -> list[Trial]:
    """Judge the candidates of one video.

    Args:
        frames: ordinal and picture, in order.
        truth: the signs' boxes.
        params: parameters of the gate; its tau is not used.
        candidates: candidates to try; unset: the defaults of :class:`Candidates`.
        seed: seed of the random candidates.
    """
    chosen = candidates or Candidates()
    rng = np.random.default_rng(seed)
    gate, camera = Gate(params), CameraShift()
    memories: dict[int, HashMemory] = {}
    previous: dict[int, tuple[int, FloatArray]] = {}
    trials = []
    for k, picture in frames:
        shift = camera.step(picture)
        for sign, box in truth.get(k, {}).items():
            memory = memories.get(sign, HashMemory.empty())
            seen, last = previous.get(sign, (-1, box))
            known = seen == k - 1 and memory.count >= chosen.history
            if known and k % chosen.every == 0 and _side(box) >= chosen.smallest:
                for genuine, candidate in _around(box, chosen, rng):
                    crop = cut(picture, candidate, gate.margin)
                    verdict = gate.judge(crop, memory, _centre(candidate), _centre(last), _side(candidate), shift)
                    trials.append(Trial(sign, k, genuine, verdict))
            memories[sign] = gate.remember(memory, cut(picture, box, gate.margin))
            previous[sign] = (k, box)
    return trials


def collection_curve(trials: Sequence[tuple[str, Trial]], tau: FloatArray) -> CollectionCurve:
    """Rates of correctly collected candidates over tau.

    Args:
        trials: pairs of a video's name and a trial.
        tau: shape (n,), ascending.

    Raises:
        ValueError: there are no genuine candidates or no patches.
    """
    signs = sorted({(video, trial.sign) for video, trial in trials})
    rates: dict[bool, list[FloatArray]] = {True: [], False: []}
    for sign in signs:
        for genuine in (True, False):
            values = [t.verdict.l_positive for v, t in trials if (v, t.sign) == sign and t.genuine is genuine]
            if values:
                confident = np.searchsorted(np.sort(values), tau, side="left") / len(values)
                rates[genuine].append(np.asarray(confident if genuine else 1.0 - confident))
    if not rates[True] or not rates[False]:
        raise ValueError("collection_curve needs genuine candidates and patches. Got none of one kind.")
    found, refused = np.mean(rates[True], axis=0), np.mean(rates[False], axis=0)
    return CollectionCurve(tau, found, refused, (found + refused) / 2)


def cut(picture: Picture, box: FloatArray, margin: float) -> Picture:
    """Cut a box with its margin out of a picture, rounded to whole pixels, borders replicated."""
    height, width = picture.shape[:2]
    x1, y1, x2, y2 = np.round(expand(box, margin)).astype(int)
    columns = np.clip(np.arange(x1, max(x2, x1 + 1)), 0, width - 1)
    rows = np.clip(np.arange(y1, max(y2, y1 + 1)), 0, height - 1)
    return np.ascontiguousarray(picture[rows[:, None], columns[None, :]])


def _around(box: FloatArray, chosen: Candidates, rng: np.random.Generator) -> list[tuple[bool, FloatArray]]:
    side = _side(box)
    found = [(True, box)]
    found += [(True, box + rng.normal(0.0, chosen.misplaced * side, 4)) for _ in range(chosen.copies)]
    for _ in range(chosen.patches):
        angle = rng.uniform(0.0, 2.0 * math.pi)
        distance = rng.uniform(chosen.nearest, chosen.farthest) * side
        found.append((False, box + np.tile([math.cos(angle) * distance, math.sin(angle) * distance], 2)))
    return found


def _centre(box: FloatArray) -> FloatArray:
    return np.asarray((box[:2] + box[2:]) / 2)


def _side(box: FloatArray) -> float:
    return float((box[2] - box[0] + box[3] - box[1]) / 2)
