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
