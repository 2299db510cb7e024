"""Messages of a run's process on a node."""

from __future__ import annotations

import io
import subprocess
from types import SimpleNamespace

import pytest

from tsr_engine.batch.node_runner import ProcessActor


def test_a_message_that_comes_during_a_poll_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    silent = SimpleNamespace(stdin=io.BytesIO(), stdout=io.BytesIO(), poll=lambda: None)
    monkeypatch.setattr(subprocess, "Popen", lambda *_, **__: silent)
    actor = ProcessActor()
    actor.start(b"")
    lines = actor.lines  # the reading thread looks it up before it adds a line, and may be stopped in between
    assert actor.poll() == ([], None)
    lines.append("done")
    assert actor.poll() == (["done"], None)
    assert actor.poll() == ([], None)
