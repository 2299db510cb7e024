"""A tracked toy drive, and a bundle of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bundle.tracked_drive import TrackedDrive, make_tracked_drive


@pytest.fixture(scope="session")
def drive(tmp_path_factory: pytest.TempPathFactory) -> TrackedDrive:
    """75 frames with two signs."""
    return make_tracked_drive(tmp_path_factory.mktemp("bundles"))


@pytest.fixture(scope="session")
def plain(drive: TrackedDrive, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bundle without expectations."""
    return drive.bundle(tmp_path_factory.mktemp("plain") / "plain.zip").path
