"""The camera's focus in a run's summary."""

from __future__ import annotations

import pytest

from app.runs.focus import focus_of
from tsr_engine.params import Params

REPORTED = Params().with_settings([("coast_foe_y", 0.44)])


@pytest.mark.parametrize("named", [True, False])
def test_a_known_focus_is_shown(named: bool) -> None:
    assert focus_of(REPORTED, named=named) == {"x": 0.5, "y": 0.44, "named": named}


def test_an_unknown_or_unused_focus_is_not_shown() -> None:
    assert focus_of(Params(), named=False) is None
    assert focus_of(REPORTED.with_settings([("motion", "paper")]), named=True) is None
