"""Plans the poles of a drive and their signs, before anything is built."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sample_videos.scenarios import Scenario
from tsr_engine.pictograms.gtsrb import N_CLASSES


class Pole(NamedTuple):
    """One pole with its signs.

    Attributes:
        s: Arc length, metres.
        d: Distance to the right of the centre line, metres.
        classes: GTSRB classes from the top down.
        hidden: Whether a bush or a parked van stands before it.
        met: Whether a lorry passes before it as we approach.
    """

    s: float
    d: float
    classes: tuple[int, ...]
    hidden: bool
    met: bool


def plan_poles(
    scenario: Scenario, bridge: tuple[float, float] | None, last: float, rng: np.random.Generator
) -> list[Pole]:
    """Plan the poles of the scenario, then all classes in turn, each once before any comes again.

    Args:
        scenario: Kind of drive.
        bridge: Arc lengths of a bridge's start and end, or None.
        last: Arc length of our car at the end.
        rng: Source of order, sides and gaps.

    Returns:
        The poles in order.
    """
    poles: list[Pole] = []
    order: list[int] = []
    s = 62.0
    lateral = 4.25 if scenario.town else 5.0
    while s < last + 30:
        if bridge is not None and bridge[0] - 9 < s < bridge[1] + 16:
            s = bridge[1] + 16
        number = len(poles)
        scripted = number < len(scenario.posts)
        if scripted:
            classes, side = scenario.posts[number]
        else:
            order = order or rng.permutation(N_CLASSES).tolist()
            classes, side = (order.pop(),), 1 if rng.random() < 0.85 else -1
            if rng.random() < 0.2:
                classes = (*classes, int(rng.integers(0, 9)))
        hidden = number in scenario.hidden or (not scripted and side > 0 and rng.random() < 0.12)
        met = number in scenario.met and side < 0
        poles.append(Pole(s, side * (lateral + float(rng.uniform(0, 0.25))), classes, hidden, met))
        s += scenario.gap * float(rng.uniform(0.85, 1.15))
    return poles
