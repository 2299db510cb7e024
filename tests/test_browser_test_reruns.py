"""A failed browser test runs once more on a new server, and fails if it fails again."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

HOOKS = "from tests.e2e.conftest import pytest_itemcollected, pytest_runtest_makereport, pytest_runtest_teardown"
WALKS = """
import pytest

made, ended = [], []


@pytest.fixture(scope="module")
def server():
    made.append(1)
    yield len(made)
    ended.append(1)


@pytest.fixture(scope="module")
def late_server(server):
    if server < 3:
        raise RuntimeError("it did not start")


def test_at_first(server):
    assert server == 1


def test_late_once(server):
    assert server == 2


def test_after_it(server):
    assert server == 2


def test_server_is_late(late_server):
    assert len(made) == 3


def test_wrong(server):
    assert server < 0


def test_after_wrong(server):
    assert (server, len(ended)) == (5, 4)
"""


def test_a_browser_test_fails_after_two_runs(tmp_path: Path) -> None:
    (tmp_path / "conftest.py").write_text(HOOKS)
    (tmp_path / "test_walks.py").write_text(WALKS)
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = slow")
    root = Path(__file__).resolve().parents[1]
    there = {**os.environ, "CHROMIUM": sys.executable}  # any program: these tests open no browser
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-p",
        "no:cacheprovider",
        "-rf",
        "--rerun-show-tracebacks",
        str(tmp_path),
    ]
    done = subprocess.run(command, cwd=root, env=there, capture_output=True, text=True, timeout=300)
    assert "1 failed, 5 passed, 3 rerun" in done.stdout, done.stdout + done.stderr
    assert "assert 4 < 0" in done.stdout
    for name in ("late_once", "server_is_late", "wrong"):
        assert f"RERUN test_walks.py::test_{name}" in done.stdout
    assert "RuntimeError: it did not start" in done.stdout, "why it failed at first is told"
