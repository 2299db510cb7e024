"""Evaluates fusion over a track's frames: correct tracks by number of frames, as in the paper's Fig. 13.

Table II counts by physical sign; :mod:`tsr_engine.evaluation.tracking` computes it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tsr_engine.io.gtsrb import CropItem, read_picture, tracks_of
from tsr_engine.params.fusion import FusionParams
from tsr_engine.protocols import CropClassifier
from tsr_engine.recognition.crops import cut
from tsr_engine.recognition.fusion import Fusion

Mode = Literal["scale", "equal", "clamped"]
MODES: tuple[Mode, ...] = ("scale", "equal", "clamped")


@dataclass(frozen=True, slots=True, eq=False)
class TrackVotes:
    """One physical sign with the classifier's probabilities for each of its frames."""

    class_id: int
    """True class."""
    scales: NDArray[np.float64]
    """Shape (t,): side of the sign in px (geometric mean of width and height), far to near."""
    probabilities: NDArray[np.float32]
    """Shape (t, c): class probabilities of each frame."""


@dataclass(frozen=True, slots=True)
class FusionReport:
    """Rates of correctly classified tracks."""

    tracks: int
    frames: tuple[int, ...]
    """Numbers of frames: 1, 2, ..."""
    rates: Mapping[str, tuple[float, ...]]
    """For each mode: share of tracks whose class is correct after each number of frames, far to near."""
    single: float
    """Share of single crops whose class is correct."""
    delta: float
    scale: float

    def as_dict(self) -> dict[str, object]:
        """The figures as values for JSON."""
        return {
            "tracks": self.tracks,
            "frames": list(self.frames),
            "rates": {mode: list(rates) for mode, rates in self.rates.items()},
            "single": self.single,
            "fusion_delta": self.delta,
            "fusion_scale": self.scale,
        }


def track_votes(
    items: Sequence[CropItem], classifier: CropClassifier, progress: Callable[[int, int], None] | None = None
) -> list[TrackVotes]:
    """Classify every frame of every track, without fusion.

    Args:
        items: crops with tracks, classes and ROIs.
        classifier: any crop classifier.
        progress: called after each track with the number done and the number to do.

    Raises:
        InputError: an item has no track, or its picture cannot be read.
    """
    result: list[TrackVotes] = []
    tracks = tracks_of(items)
    for (class_id, _), frames in tracks.items():
        boxes = [item.roi for item in frames if item.roi is not None]
        crops = [cut(read_picture(item), item.roi, classifier.margin) for item in frames if item.roi is not None]
        scales = np.array([np.sqrt((x2 - x1) * (y2 - y1)) for x1, y1, x2, y2 in boxes], dtype=np.float64)
        result.append(TrackVotes(class_id, scales, classifier.probabilities(crops)))
        if progress is not None:
            progress(len(result), len(tracks))
    return result


def evaluate_fusion(
    tracks: Sequence[TrackVotes], params: FusionParams | None = None, longest: int = 30
) -> FusionReport:
    """Share of tracks whose fused class is correct after 1, 2, ... ``longest`` frames, far to near, for all modes.

    A shorter track counts with all of its frames.

    Args:
        tracks: at least one.
        params: ``fusion_delta`` and ``fusion_scale``; its mode is not used.
        longest: largest number of frames, >= 1.

    Raises:
        ValueError: there are no tracks.
    """
    if not tracks:
        raise ValueError("evaluate_fusion needs at least one track. Got none.")
    params = params or FusionParams()
    rates: dict[str, tuple[float, ...]] = {}
    for mode in MODES:
        settings = params.model_copy(update={"fusion_mode": mode})
        rates[mode] = tuple(float(r) for r in np.mean([_right(track, settings, longest) for track in tracks], axis=0))
    right = [track.probabilities.argmax(1) == track.class_id for track in tracks]
    return FusionReport(
        tracks=len(tracks),
        frames=tuple(range(1, longest + 1)),
        rates=rates,
        single=float(np.concatenate(right).mean()),
        delta=params.fusion_delta,
        scale=params.fusion_scale,
    )


def _right(track: TrackVotes, params: FusionParams, longest: int) -> NDArray[np.bool_]:
    """Whether the fused class is correct after 1, ..., ``longest`` frames, shape (longest,)."""
    state = Fusion.start(params, track.probabilities.shape[1])
    right = np.zeros(longest, dtype=np.bool_)
    for i in range(longest):
        if i < len(track.scales):
            state, record = state.update(track.probabilities[i], float(track.scales[i]))
            right[i] = record.class_id == track.class_id
        elif i:
            right[i] = right[i - 1]
    return right
