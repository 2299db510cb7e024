"""Processes of drives, forked from one that has loaded the engine: each costs 3 s of CPU less."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Mapping, Sequence
from types import SimpleNamespace, TracebackType
from typing import IO

import pytest

from tests.forked_program import ForkedProgram
from tsr_engine.batch import worker

__all__ = ["fork_workers"]


class ForkedWorker(ForkedProgram):
    """The part of ``subprocess.Popen`` that ``run_task`` needs.

    Attributes:
        stdin: takes the task.
    """

    def __init__(self, command: Sequence[str], *, env: Mapping[str, str], **_: object) -> None:
        assert command[1:] == ["-m", worker.__name__]
        read, written = os.pipe()
        super().__init__(f"{__name__}:track_drive", env=env, stdin=read, stdout=subprocess.PIPE)
        os.close(read)
        self.stdin: IO[str] = os.fdopen(written, "w", encoding="utf-8")

    def __enter__(self) -> ForkedWorker:
        return self

    def __exit__(
        self, _kind: type[BaseException] | None, _error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        assert self.stdout is not None
        self.stdout.close()
        self.stdin.close()
        self.wait()


def track_drive(_arguments: list[str]) -> None:
    """``python -m tsr_engine.batch.worker``, which reports often."""
    worker.PROGRESS_INTERVAL_S = 0.05  # type: ignore[misc]
    worker.main()


def fork_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on ``run_task`` forks the processes of drives."""
    subprocess_module = SimpleNamespace(Popen=ForkedWorker, PIPE=subprocess.PIPE)
    monkeypatch.setattr("tsr_engine.batch.process.subprocess", subprocess_module)
