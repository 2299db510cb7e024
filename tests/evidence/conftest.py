"""The header of a run, and the folder of its evidence."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.evidence.synthetic_evidence import make_header
from tsr_engine.evidence import RunHeader


@pytest.fixture
def header() -> RunHeader:
    return make_header()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "run"
