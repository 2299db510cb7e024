"""Kills and full disks lose no acknowledged edit."""

from __future__ import annotations

import sqlite3
import subprocess
from pathlib import Path

import pytest

from tests.forked_program import ForkedProgram

PROGRAM = "tests.app.edits.endless_edits:main"


@pytest.mark.parametrize("after", [1, 40])
def test_kill_keeps_every_acknowledged_edit(tmp_path: Path, after: int) -> None:
    file = tmp_path / "t.sqlite"
    child = ForkedProgram(PROGRAM, [str(file)], stdout=subprocess.PIPE)
    assert child.stdout is not None
    with child.stdout as stream:
        reported = [int(stream.readline()) for _ in range(after)]
        child.kill()
        reported += [int(line) for line in stream.read().split("\n") if line.strip()]
    child.wait(60)
    with sqlite3.connect(file) as database:
        stored = {row[0] for row in database.execute("SELECT op_id FROM edits")}
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        revision = database.execute("SELECT revision FROM track_documents").fetchone()[0]
    database.close()
    assert {f"op-{step:0>8}" for step in reported} <= stored
    assert revision == len(stored)


def test_a_file_size_limit_is_reported_and_temporary(tmp_path: Path) -> None:
    child = ForkedProgram(PROGRAM, [str(tmp_path / "t.sqlite"), "600000"], stdout=subprocess.PIPE)
    assert child.stdout is not None
    with child.stdout as stream:
        lines = stream.read().split()
    assert child.wait(60) == 0
    where = lines.index("full")
    assert lines[where + 1] == "507:storage_limit"
    assert int(lines[where + 2]) == where, "acknowledged rows were lost"
    assert len(lines) > where + 3, "no edit went through once there was room again"
