"""Messages of a run's process on a node."""

from __future__ import annotations

import threading
from types import SimpleNamespace
from typing import Any

from tsr_engine.batch.node_runner import _ProcessActor


def test_a_message_that_comes_during_a_poll_is_not_lost() -> None:
    actor: Any = _ProcessActor()
    actor._process, actor._reader = SimpleNamespace(poll=lambda: None), threading.Thread()
    lines = actor._lines  # the reading thread looks it up before it adds a line, and may be stopped in between
    assert actor.poll() == ([], None)
    lines.append("done")
    assert actor.poll() == (["done"], None)
    assert actor.poll() == ([], None)
