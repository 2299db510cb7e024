"""A job without progress is ended with a message; a job with progress may take any time."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from app.context import build_context
from app.jobs.watchdog import watchdog
from app.settings import Settings
from app.videos import importing
from sample_videos import SHIPPED
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import SECRET
from tsr_engine.errors import VideoError


@pytest.fixture
def ended(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """Set when the process would have ended."""
    event = threading.Event()
    monkeypatch.setattr(os, "_exit", lambda _code: event.set())
    return event


def compute(seconds: float) -> None:
    until = time.process_time() + seconds
    while time.process_time() < until:
        pass


def test_progress_and_waiting_are_allowed(ended: threading.Event) -> None:
    task: Any = None  # no progress is reported
    with watchdog(task, 0.5, lambda: "", interval=0.02) as step:
        for _ in range(8):
            compute(0.1)
            step()
        time.sleep(0.8)
    assert not ended.is_set()


def test_an_import_with_a_hanging_decoder_fails_with_a_sentence(
    ended: threading.Event, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(importing, "MAX_FRAME_CPU_S", 0.5)

    def decode(_file: object, _copy: Path, progress: Callable[[int], None]) -> None:
        for frame in range(12):
            compute(0.05)
            progress(frame + 1)
        while not ended.is_set():
            compute(0.05)
        raise VideoError("this comes too late to be reported")

    monkeypatch.setattr(importing, "decode_all", decode)
    context = build_context(Settings(home=tmp_path, roots=(tmp_path,), sample=False, workers=0, token=SECRET))
    video = context.videos.add_path(str(SHIPPED[0].video))
    run_jobs(context, "import")
    view = context.videos.view(video.id)
    assert view.state == "failed"
    assert view.error is not None
    assert view.error.startswith("Frame 12 could not be decoded within 0 s of computing. The file may be damaged there")
    context.close()
