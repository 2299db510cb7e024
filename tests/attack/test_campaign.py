"""The campaign of ``make attack``, short."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.attack.campaign import Scale, campaign


@pytest.mark.slow
def test_every_stage_holds(tmp_path: Path) -> None:
    """But for those that other tests hold in less time, and the disk that root alone can mount."""
    stages = ("kills", "damaged files", "disk", "clock")
    scale = Scale(kills=2, seconds=0, people=4, least=12, jumps=3)
    assert set(campaign(tmp_path, 1, scale, stages, real=False)) == set(stages)
