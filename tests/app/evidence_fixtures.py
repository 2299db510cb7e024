"""Fixtures that tests of evidence, what-ifs, comparisons and truths share."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType

import long_run
import pytest
import toy_home


@pytest.fixture(scope="session")
def toy_homes() -> ModuleType:
    """Makes data folders."""
    return toy_home


@pytest.fixture(scope="session")
def long_runs() -> ModuleType:
    """Makes long runs."""
    return long_run


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[toy_home.ToyHome]:
    """A data folder with one tracked toy drive."""
    made = toy_home.make_home(tmp_path_factory.mktemp("evidence"))
    yield made
    made.evidence.close()
    made.database.close()
