"""Evidence with something in every layer, bar-coded clips, and recordings read back as plain arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from tests.io import corpus as bar_coded
from tests.recording import read_back as reading
from tests.recording import scenes as evidence


@pytest.fixture(scope="session")
def scenes() -> Any:
    """Makes evidence."""
    return evidence


@pytest.fixture(scope="session")
def read_back() -> Any:
    """Reads recordings."""
    return reading


@pytest.fixture(scope="session")
def corpus() -> Any:
    """Makes awkward videos."""
    return bar_coded


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Any]:
    """A function from the name of a kind of video to the made file."""
    return bar_coded.maker(tmp_path_factory.mktemp("corpus"))
