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
def made(corpus: Any, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Any]:
    """A function from the name of a kind to the made file and the truth about it."""
    folder = tmp_path_factory.mktemp("corpus")
    files: dict[str, Any] = {}

    def get(name: str) -> Any:
        if name not in files:
            if name.startswith("edit_list"):
                source, skip, keep = {
                    "edit_list": ("b_frames", 12, 30),
                    "edit_list_inside_gop": ("b_frames", 17, 22),
                    "edit_list_open_gop": ("open_gop", 14, 28),
                    "edit_list_tail": ("constant", 0, 31),
                }[name]
                files[name] = corpus.with_edit_list(get(source), folder / f"{name}.mp4", skip, keep)
            else:
                files[name] = corpus.make(corpus.RECIPES[name], folder, name)
        return files[name]

    return get
