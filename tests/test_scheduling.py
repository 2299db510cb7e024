"""A crash of a process of tests fails one test and no more: the run ends."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

CONFTEST = """
import time

from xdist.workermanage import WorkerController

from tests.conftest import pytest_xdist_make_scheduler

send = WorkerController.send_runtest_some


def send_late(node, indices):
    if getattr(node, "last", None) == [60, 61]:
        time.sleep(0.5)  # the process of test_30.py crashes between the decision to give it a file and the sending
    node.last = indices
    send(node, indices)


WorkerController.send_runtest_some = send_late
"""
TESTS = """
import os
import time
from pathlib import Path

import pytest

CRASHED = Path(__file__).with_name("crashed")


@pytest.mark.parametrize("number", range(2))
def test_it(number):
    if "test_30" in __file__ and number == 0 and not CRASHED.exists():
        CRASHED.touch()
        time.sleep(0.2)
        os._exit(1)
"""


def test_a_run_ends_after_a_crash(tmp_path: Path) -> None:
    (tmp_path / "conftest.py").write_text(CONFTEST)
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    for number in range(40):
        (tmp_path / f"test_{number:02}.py").write_text(TESTS)
    options = ["-p", "no:cacheprovider", "--numprocesses", "2", "--dist", "loadfile", "--no-loadscope-reorder"]
    command = [sys.executable, "-m", "pytest", *options, str(tmp_path)]
    root = Path(__file__).resolve().parents[1]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=120)
    assert "1 failed, 80 passed" in done.stdout, done.stdout + done.stderr
    assert "crashed while running 'test_30.py::test_it[0]'" in done.stdout
