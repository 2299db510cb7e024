"""The experiment on the queue's uncertainty."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.experiments.uncertainty import NAMES, JudgedTracks, fit, held_out


def test_clips_of_the_same_place_are_left_out_together() -> None:
    rng = np.random.default_rng(0)
    clips = np.repeat(["02_71ec1e", "03_c0da85", "SH13_9f8bd8", "01_076852"], 20)
    terms = rng.random((80, len(NAMES)))
    changed = rng.random(80) < 0.5
    judged = JudgedTracks(terms, np.zeros(80), changed, clips, np.repeat("default", 80), ("",) * 80)

    found = held_out(judged)

    same_place = np.isin(clips, ["02_71ec1e", "03_c0da85"])
    for fold in (same_place, clips == "SH13_9f8bd8", clips == "01_076852"):
        without = fit(terms[~fold], changed[~fold]).predict_proba(terms[fold])[:, 1]
        assert found[fold] == pytest.approx(without)
