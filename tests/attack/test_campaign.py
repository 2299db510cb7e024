"""The campaign of ``make attack``, short."""

from __future__ import annotations

from pathlib import Path

from tests.attack.campaign import campaign


def test_every_stage_holds(tmp_path: Path) -> None:
    said = campaign(tmp_path, seed=1, count=2, seconds=0, people=4, least=12)
    assert set(said) == {"kills", "damaged files", "memory", "disk", "clock"}
