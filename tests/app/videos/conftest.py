"""The awkward videos of the engine's tests, and a server that has imported some."""

from __future__ import annotations

from types import ModuleType

import pytest

from tests.io import corpus as bar_coded


@pytest.fixture(scope="session")
def corpus() -> ModuleType:
    """The module that makes bar-coded videos."""
    return bar_coded
