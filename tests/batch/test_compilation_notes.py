"""A batch says once that its processes compile kernels."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import pytest

from tests.waiting import wait_until
from tsr_engine import compilation
from tsr_engine.batch import executors, process, worker
from tsr_engine.batch.manifest import Identity
from tsr_engine.batch.process import run_task
from tsr_engine.batch.run import BatchRequest, run_batch
from tsr_engine.batch.task import DriveTask, Outcome
from tsr_engine.cli.batch import BatchProgressPrinter
from tsr_engine.compilation import COMPILING
from tsr_engine.errors import InputError
from tsr_engine.params import Params

Capture = pytest.CaptureFixture[str]


def test_a_worker_reports_that_it_compiles(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    notes: list[Any] = []

    def compile_only(*_: Any, **__: Any) -> None:
        numba.njit(lambda x: x + 1)(1)
        wait_until(lambda: notes)
        raise InputError("that is enough")

    monkeypatch.setattr(compilation, "NEXT_KERNEL_S", 60.0)
    monkeypatch.setattr("tsr_engine.batch.child_process.send_message", notes.append)
    monkeypatch.setattr("tsr_engine.runs.track_video.track_video", compile_only)
    order = DriveTask("/none.mp4", str(tmp_path / "out"), Params().model_dump(mode="json"))
    with pytest.raises(InputError, match="that is enough"):
        worker._track(order)
    assert notes == [{"note": COMPILING}]


def test_the_note_of_a_worker_is_no_outcome(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = [{"note": COMPILING}, {"note": ""}, {"at": 1, "of": 2}, {"done": {"frames": 2}}]
    code = f"import sys; sys.stdin.read(); print({chr(10).join(map(json.dumps, lines))!r})"
    start: Callable[..., Any] = subprocess.Popen
    monkeypatch.setattr(process.subprocess, "Popen", lambda _, **facts: start([sys.executable, "-c", code], **facts))
    notes: list[str] = []
    outcome = run_task(DriveTask("/a.mp4", "/out", {}), note=notes.append)
    assert (outcome.result, notes) == ({"frames": 2}, [COMPILING, ""])


def test_many_notes_are_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    def noted(order: DriveTask, at: Any, started: Any, note: Callable[[str], None]) -> Outcome:
        for text in (COMPILING, "", COMPILING):
            note(text)
        return Outcome(None, "damaged")

    monkeypatch.setattr(executors, "run_task", noted)
    monkeypatch.setattr("tsr_engine.batch.run.write_summary", lambda *_: None)
    drives = [tmp_path / f"{k}.mp4" for k in range(3)]
    request = BatchRequest(drives, tmp_path / "out", Identity("1", {}, {}), DriveTask("", "", {}), jobs=2)
    run_batch(request, BatchProgressPrinter(), lambda: False)
    error_output = capsys.readouterr().err.splitlines()
    assert error_output.count(f"tsr: {COMPILING.capitalize()}.") == 1
    assert error_output[-1].startswith("tsr: 3 of 3 drives, 3 failed")
    assert len(error_output) == 2
