"""What all tests share: where the real data is, and folders made from its archives once a session."""

from __future__ import annotations

import os
import tarfile
from pathlib import Path

import pytest
from hypothesis import settings

# The same random examples every time: a change is judged by what it changes. TSR_EXPLORE=1 draws new ones.
settings.register_profile("same", derandomize=True, deadline=None)
if not os.environ.get("TSR_EXPLORE"):
    settings.load_profile("same")


def _data_root() -> Path | None:
    root = os.environ.get("TSR_DATA")
    return Path(root).resolve() if root else None


@pytest.fixture(scope="session")
def data_root() -> Path:
    """The folder of real data that TSR_DATA names; skips where it is unset."""
    root = _data_root()
    if root is None:
        pytest.skip("TSR_DATA is not set: no real data here")
    if not root.is_dir():
        pytest.fail(f"TSR_DATA names {root}, which is not a folder")
    return root


def _unpack(archive: Path, folder: Path) -> Path:
    with tarfile.open(archive) as tar:
        tar.extractall(folder, filter="data")
    return folder


@pytest.fixture(scope="session")
def gtsdb(data_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with GTSDB scenes and their gt.txt."""
    return _unpack(data_root / "gtsdb_train.tar", tmp_path_factory.mktemp("gtsdb")) / "gtsdb"


@pytest.fixture(scope="session")
def gtsrb(data_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with GTSRB class folders."""
    return _unpack(data_root / "gtsrb_train.tar.gz", tmp_path_factory.mktemp("gtsrb")) / "gtsrb"


@pytest.fixture(scope="session")
def clips(data_root: Path) -> Path:
    """The folder of real dash-cam clips."""
    return data_root / "clips"
