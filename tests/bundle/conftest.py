"""A tracked toy drive, and a bundle of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bundle.bundle_toys import Drive, make_drive


@pytest.fixture(scope="session")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Drive:
    """75 frames with two signs."""
    return make_drive(tmp_path_factory.mktemp("bundles"))


@pytest.fixture(scope="session")
def plain(drive: Drive, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bundle without expectations."""
    return drive.bundle(tmp_path_factory.mktemp("plain") / "plain.zip").path
