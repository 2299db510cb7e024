"""Work on all cores: order and random numbers depend only on the items."""

from __future__ import annotations

import time

import numpy as np
import pytest

from tsr_engine.training.public import parallel as module
from tsr_engine.training.public.parallel import map_on_cores


def drawn(item: int, rng: np.random.Generator) -> tuple[int, float]:
    time.sleep(0.002 * (7 - item % 8))
    return item, float(rng.random())


def test_the_number_of_cores_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    made = []
    seen: list[tuple[str, int, int]] = []
    for cores in (1, 3):
        monkeypatch.setattr(module, "training_threads", lambda cores=cores: cores)
        made.append(
            list(map_on_cores(drawn, range(20), np.random.default_rng(5), lambda *told: seen.append(told), "drawing"))
        )
    assert made[0] == made[1]
    assert seen == [("drawing", number, 20) for number in range(20)] * 2
    assert [item for item, _ in made[0]] == list(range(20))
    assert len({value for _, value in made[0]}) == 20


def test_an_error_on_another_core_is_raised_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "training_threads", lambda: 2)

    def fails(item: int, rng: np.random.Generator) -> int:
        if item == 3:
            raise OSError("no such picture")
        return item

    with pytest.raises(OSError, match="no such picture"):
        list(map_on_cores(fails, range(10), np.random.default_rng(0), lambda *_: None, ""))
