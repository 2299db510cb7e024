"""The awkward videos of the engine's tests, and a server that has imported some."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import pytest

from tests.io import corpus as bar_coded

sys.path.insert(0, str(Path(__file__).parents[1]))


@pytest.fixture(scope="session")
def corpus() -> ModuleType:
    """The module that makes bar-coded videos."""
    return bar_coded
