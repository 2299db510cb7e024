"""Labels with pictograms, and parameters as the engine declares them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from app.catalogue import Pictograms, labels, parameters
from tsr_engine.params import PRESETS, Params
from tsr_engine.params.replayable import FIXED


def test_all_classes_have_a_name_and_a_picture() -> None:
    found = labels()
    assert [label.id for label in found] == list(range(43))
    assert found[14].name == "stop"
    assert found[14].picture == "/api/labels/14.png"


def test_pictograms_differ_and_are_transparent_around_the_sign() -> None:
    drawn = Pictograms()
    pictures = [cv2.imdecode(np.frombuffer(drawn.png(c, 48), np.uint8), cv2.IMREAD_UNCHANGED) for c in range(43)]
    assert {picture.shape for picture in pictures} == {(48, 48, 4)}
    assert len({picture.tobytes() for picture in pictures}) == 43
    for picture in pictures:
        assert picture[0, 0, 3] == 0
        assert picture[24, 24, 3] == 255
        # Smooth edges: some pixels are neither inside nor outside.
        assert np.count_nonzero((picture[..., 3] > 0) & (picture[..., 3] < 255)) > 20


def test_pictograms_are_drawn_once() -> None:
    drawn = Pictograms(most=2)
    first = drawn.png(1, 32)
    assert drawn.png(1, 32) is first
    drawn.png(2, 32), drawn.png(3, 32)
    assert drawn.png(1, 32) == first
    with pytest.raises(KeyError, match="gtsrb/43"):
        drawn.png(43, 32)


def test_parameters_are_those_of_the_engine() -> None:
    found = {(p.section, p.name): p for p in parameters()}
    assert list(found) == list(Params.names())
    defaults = Params().model_dump(mode="json")
    for (section, name), parameter in found.items():
        assert parameter.default == defaults[section][name]
        assert parameter.description
        fixed = section == "detector" or f"{section}.{name}" in FIXED
        assert parameter.replayable is not fixed
        assert parameter.presets == ({"paper": _plain(PRESETS["paper"][name])} if name in PRESETS["paper"] else {})
    tau = found["gate", "tau"]
    assert (tau.type, tau.low, tau.high) == ("number", 0.0, 1e6)
    assert found["tracking", "motion"].choices == ["paper", "constant_velocity", "looming"]
    assert found["prior", "use_prior"].type == "boolean"
    assert (found["prior", "prior_lambda"].type, found["prior", "prior_lambda"].default) == ("number", None)
    assert found["gate", "hash_memory"].type == "integer"
    assert found["online", "search_scales"].type == "text"


def test_limits_are_the_ones_that_are_enforced() -> None:
    for parameter in parameters():
        if parameter.type not in ("number", "integer"):
            continue
        for limit, step in ((parameter.low, -1.0), (parameter.high, 1.0)):
            if limit is not None:
                with pytest.raises(Exception, match=parameter.name):
                    Params().with_settings([(f"{parameter.section}.{parameter.name}", limit + step)])


def _plain(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value
