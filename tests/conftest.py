"""Shared fixtures: the folder of the real data, and folders unpacked from its archives once per session."""

from __future__ import annotations

import gc
import os
import sys
import tarfile
from collections.abc import Generator
from pathlib import Path

import pytest
from hypothesis import settings
from xdist.remote import Producer

from tests.e2e.chromium import INSTALL_HINT
from tests.scheduling import FileScheduling

# Processes of tests share few cores: with BLAS threads of their own they wait for each other, up to six times as long.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Hundreds of tests start processes of their own: without kept bytecode, each compiles every module again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
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


def _unpack(archive: Path, folder: Path, suffix: str = "") -> Path:
    """Unpack the files whose names end so."""
    with tarfile.open(archive) as tar:
        for member in tar:
            if member.name.endswith(suffix):
                tar.extract(member, folder, filter="data")
    return folder


@pytest.fixture(scope="session")
def gtsdb(data_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with GTSDB scenes and their gt.txt."""
    return _unpack(data_root / "gtsdb_train.tar", tmp_path_factory.mktemp("gtsdb")) / "gtsdb"


@pytest.fixture(scope="session")
def gtsrb(data_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with GTSRB class folders and their tables, without the 39,209 pictures."""
    return _unpack(data_root / "gtsrb_train.tar.gz", tmp_path_factory.mktemp("gtsrb"), ".csv") / "gtsrb"


@pytest.fixture(scope="session")
def clips(data_root: Path) -> Path:
    """The folder of real dash-cam clips."""
    return data_root / "clips"


NEEDS = (
    ("TSR_DATA is not set", "tests did not run: they need real data. Name its folder: make test TSR_DATA=/path."),
    ("e2e/", f"tests did not run: they need a browser, and there is no Chromium. {INSTALL_HINT}"),
)
"""The reason of skipped tests, and how to run them."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with slow tests come first, so that at the end no process works on a long one while the others are idle."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> FileScheduling:
    """All tests of a file run in one process, because they share fixtures."""
    return FileScheduling(config, log)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Modules and tests live until the end: a search for garbage among them takes a second each time and finds none.

    What tests leave behind is searched seldom: after 20,000 new objects, not after 700 as by default.
    """
    gc.set_threshold(20_000)
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> Generator[None]:
    """Before the closing line: which tests did not run, and how to make them."""
    yield
    skipped = [str(report.longrepr) for report in terminalreporter.stats.get("skipped", ())]
    for reason, sentence in NEEDS:
        count = sum(reason in text for text in skipped)
        if count:
            terminalreporter.write_line(f"{count} {sentence}", yellow=True)
