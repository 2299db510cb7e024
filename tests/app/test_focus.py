"""What a run's summary says of where its camera looks."""

from __future__ import annotations

import pytest

from app.runs.focus import focus_of
from tsr_engine.params import Params

REPORTED = Params().with_settings([("coast_foe_y", 0.44)])


@pytest.mark.parametrize("named", [True, False])
def test_a_focus_that_is_known_is_told(named: bool) -> None:
    assert focus_of(REPORTED, named=named) == {"x": 0.5, "y": 0.44, "named": named}


def test_an_unknown_one_and_a_motion_model_without_one_say_nothing() -> None:
    assert focus_of(Params(), named=False) is None
    assert focus_of(REPORTED.with_settings([("motion", "paper")]), named=True) is None
