"""Homes with an imported clip, and the evidence of an uninterrupted run."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.app.jobs.job_server import JobServer, make_job_server
from tests.app.long_run import SEGMENT, make_long_run

__all__ = ["drive", "imported_home", "job_server", "reference_run"]


@pytest.fixture(scope="session")
def imported_home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A home with an imported clip; copied for each test."""
    home = tmp_path_factory.mktemp("jobs") / "home"
    make_job_server(home).context.close()
    return home


@pytest.fixture
def job_server(imported_home: Path, tmp_path: Path) -> Iterator[JobServer]:
    """A home of the test's own."""
    shutil.copytree(imported_home, tmp_path / "home")
    job_server = make_job_server(tmp_path / "home")
    yield job_server
    job_server.close()
    job_server.context.close()


@pytest.fixture(scope="session")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A home with a made-up run; copied for each test."""
    home = tmp_path_factory.mktemp("drive") / "home"
    make_long_run(home, 2 * SEGMENT, 12)
    return home


@pytest.fixture(scope="session")
def reference_run(imported_home: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The evidence of a run that nobody disturbed.

    A worker makes it, as it makes those that are compared with it: how a process lays out its memory can move the last
    bits of a sum.
    """
    home = tmp_path_factory.mktemp("undisturbed") / "home"
    shutil.copytree(imported_home, home)
    made = make_job_server(home)
    made.open()
    run_id = made.start()
    assert made.ended(run_id).state == "complete"
    made.close()
    made.context.close()
    return made.evidence(run_id)
