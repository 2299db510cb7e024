"""One corpus of awkward videos for all tests of this folder, made once a session."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from tests.io import corpus as bar_coded


@pytest.fixture(scope="session")
def corpus() -> Any:
    """The module that makes videos."""
    return bar_coded


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Any]:
    """A function from the name of a kind to the made file and the truth about it."""
    return bar_coded.maker(tmp_path_factory.mktemp("corpus"))
