"""Kill -9, a full disk, and a reader during writing, with the writer in a separate process."""

from __future__ import annotations

import random
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.evidence.synthetic_evidence import make_frame
from tsr_engine.errors import EvidenceError
from tsr_engine.evidence import EvidenceReader, EvidenceWriter, RunHeader, differences

SCRIPT = Path(__file__).with_name("write_forever.py")


def start(folder: Path, limit: int = 0) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, str(SCRIPT), str(folder), str(limit)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def count_checked_frames(folder: Path) -> int:
    """The number of frames, after checking each of them."""
    with EvidenceReader(folder) as run:
        count = 0
        for count, evidence in enumerate(run.frames(), start=1):
            assert list(differences(make_frame(count - 1, tracks=(count - 1) % 3), evidence)) == []
        assert count == len(run)
        assert [t.frames for t in run.tracks()] == [n for n in (count - (count + 2) // 3, count // 3) if n]
    return count


def test_killed_at_random_moments(folder: Path) -> None:
    moments = random.Random(7)
    committed = -1
    for _ in range(4):
        process = start(folder)
        assert process.stdout is not None
        seen = process.stdout.readline()
        time.sleep(moments.uniform(0.0, 0.15))
        process.kill()
        rest, errors = process.communicate()
        assert process.returncode == -9, errors
        # A line that the kill truncated is no promise.
        whole = [line for line in (seen + rest).splitlines(keepends=True) if line.endswith("\n")]
        count = count_checked_frames(folder)
        assert count % 5 == 0
        assert count - 1 >= int(whole[-1]) > committed
        committed = count - 1
        with EvidenceReader(folder) as run:
            assert run.state == "interrupted"
            assert run.last_empty_frame() == committed - committed % 3
    with sqlite3.connect(folder / "evidence.sqlite") as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    connection.close()


@pytest.mark.parametrize("limit", [300_000, 1_000_000])
def test_a_limit_on_files(folder: Path, header: RunHeader, limit: int) -> None:
    process = start(folder, limit)
    output, errors = process.communicate(timeout=120)
    assert process.returncode == 6, errors
    assert "Raise the limit on files (ulimit -f), then resume." in errors
    assert "Traceback" not in errors
    count = count_checked_frames(folder)
    assert count - 1 == int(output.split()[-1])
    with EvidenceWriter.resume(folder, header) as writer:
        assert writer.last_frame == count - 1
        writer.append(make_frame(count, tracks=count % 3))
    assert count_checked_frames(folder) == count + 1


def test_reading_while_another_process_writes(folder: Path, header: RunHeader) -> None:
    process = start(folder)
    try:
        assert process.stdout is not None
        process.stdout.readline()
        with EvidenceReader(folder) as run:
            assert run.state == "running"
            with pytest.raises(EvidenceError, match="Another process is writing"):
                EvidenceWriter.resume(folder, header)
            lengths = []
            for _ in range(10):
                announced = int(process.stdout.readline())
                assert len(run) > announced
                last = run.last_frame
                assert last is not None
                (evidence,) = run.frames(last, last + 1)
                assert list(differences(make_frame(last, tracks=last % 3), evidence)) == []
                lengths.append(len(run))
            assert lengths == sorted(lengths)
            assert lengths[-1] > lengths[0]
    finally:
        process.kill()
        process.communicate()
