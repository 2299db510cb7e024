"""A short campaign of ``make attack``."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.attack.campaign import campaign
from tests.attack.campaign_stages import Scale


@pytest.mark.slow
def test_every_stage_holds(tmp_path: Path) -> None:
    """Without the stages that other tests cover faster, and without the disk that only root can mount."""
    stages = ("kills", "damaged files", "disk", "clock")
    scale = Scale(kills=2, seconds=0, people=4, min_imports=12, jumps=3)
    assert set(campaign(tmp_path, 1, scale, stages, real=False)) == set(stages)
