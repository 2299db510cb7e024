"""Evidence with something in every layer, bar-coded clips, and recordings read back as plain arrays."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest


def _load(name: str, path: Path) -> ModuleType:
    """A module of another folder of tests; they are no packages."""
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
    return sys.modules[name]


TESTS = Path(__file__).parents[1]
_load("recording_read_back", Path(__file__).with_name("read_back.py"))


@pytest.fixture(scope="session")
def scenes() -> Any:
    """Makes evidence."""
    return _load("recording_scenes", Path(__file__).with_name("scenes.py"))


@pytest.fixture(scope="session")
def read_back() -> Any:
    """Reads recordings."""
    return sys.modules["recording_read_back"]


@pytest.fixture(scope="session")
def corpus() -> Any:
    """Makes awkward videos."""
    return _load("recording_corpus", TESTS / "io" / "corpus.py")


@pytest.fixture(scope="session")
def made(corpus: Any, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Any]:
    """A function from the name of a kind of video to the made file."""
    folder = tmp_path_factory.mktemp("corpus")
    files: dict[str, Any] = {}

    def get(name: str) -> Any:
        if name not in files and name == "edit_list_inside_gop":
            files[name] = corpus.with_edit_list(get("b_frames"), folder / f"{name}.mp4", 17, 22)
        elif name not in files:
            files[name] = corpus.make(corpus.RECIPES[name], folder, name)
        return files[name]

    return get
