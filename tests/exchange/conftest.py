"""What tests of formats have in common."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest

pytest.register_assert_rewrite("tests.exchange.losses")  # it says what differs, as a test does

from tests.exchange.cvat_files import Read, read_cvat  # noqa: E402


@pytest.fixture
def read_file(tmp_path: Path) -> Read:
    """Reads text as a file of CVAT for video."""
    return partial(read_cvat, tmp_path)
