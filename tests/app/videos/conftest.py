"""The awkward videos of the engine's tests, and a server that has imported some."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))


@pytest.fixture(scope="session")
def corpus() -> ModuleType:
    """The module that makes bar-coded videos."""
    path = Path(__file__).parents[2] / "io" / "corpus.py"
    spec = importlib.util.spec_from_file_location("tsr_tests_served_corpus", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module
