"""One corpus of unusual videos for all tests of this folder, made once a session."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.io import video_corpus


@pytest.fixture(scope="session")
def make_video(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], video_corpus.CorpusVideo]:
    """A function from the name of a kind to a file with its ground truth."""
    return video_corpus.maker(tmp_path_factory.mktemp("corpus"))
