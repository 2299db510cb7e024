"""Parameters as the engine declares them."""

from __future__ import annotations

import pytest

from app.parameter_catalogue import parameters
from tsr_engine.params import PRESETS, Params
from tsr_engine.params.replayable import FIXED


def test_parameters_equal_those_of_the_engine() -> None:
    found = {(p.section, p.name): p for p in parameters()}
    assert list(found) == list(Params.names())
    defaults = Params().model_dump(mode="json")
    for (section, name), parameter in found.items():
        assert parameter.default == defaults[section][name]
        assert parameter.description
        fixed = section == "detector" or f"{section}.{name}" in FIXED
        assert parameter.replayable is not fixed
        assert parameter.presets == {preset: _as_list(own[name]) for preset, own in PRESETS.items() if name in own}
    tau = found["gate", "tau"]
    assert (tau.type, tau.low, tau.high) == ("number", 0.0, 1e6)
    assert found["tracking", "motion"].choices == ["paper", "constant_velocity", "looming"]
    assert found["prior", "use_prior"].type == "boolean"
    assert (found["prior", "prior_lambda"].type, found["prior", "prior_lambda"].default) == ("number", None)
    assert found["gate", "hash_memory"].type == "integer"
    assert found["online", "search_scales"].type == "text"


def test_limits_are_enforced() -> None:
    for parameter in parameters():
        if parameter.type not in ("number", "integer"):
            continue
        for limit, step in ((parameter.low, -1.0), (parameter.high, 1.0)):
            if limit is not None:
                with pytest.raises(Exception, match=parameter.name):
                    Params().with_settings([(f"{parameter.section}.{parameter.name}", limit + step)])


def _as_list(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value
