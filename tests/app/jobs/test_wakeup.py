"""The connection from the server to the standby worker."""

from __future__ import annotations

import os
import time

import pytest

from app.jobs import worker
from app.jobs.bell import Bell, Expected, Listener
from app.jobs.kinds import JobKinds


def test_a_call_ends_the_wait_and_the_newest_expected_job_counts() -> None:
    bell = Bell()
    listener = Listener(bell.heard)
    try:
        assert listener.wait(0.0) is None
        bell.ring()
        began = time.monotonic()
        assert listener.wait(60.0) is None
        assert time.monotonic() - began < 30
        bell.ring(("follow", {"frame": 1}))
        bell.ring()
        bell.ring(("follow", {"frame": 2}))
        assert listener.wait(60.0) == ("follow", {"frame": 2})
    finally:
        bell.close()


def test_a_standby_worker_prepares_for_the_expected_job(monkeypatch: pytest.MonkeyPatch) -> None:
    bell = Bell()
    heard: list[Expected] = []
    monkeypatch.setattr(worker, "Listener", lambda: Listener(bell.heard))
    bell.ring(("follow", {"frame": 7}))
    worker.work(lambda: False, heard.append, JobKinds([], worker="w"), lambda: bool(heard), stays=True)
    assert heard == [("follow", {"frame": 7})]
    bell.close()


def test_an_unresponsive_worker_blocks_nobody() -> None:
    bell = Bell()
    try:
        for _ in range(5000):  # far more than the pipe's capacity
            bell.ring(("follow", {"frame": 10**9}))
        assert Listener(bell.heard).wait(1.0) == ("follow", {"frame": 10**9})
    finally:
        bell.close()


def test_the_end_of_the_server_is_not_a_call() -> None:
    receive, send = os.pipe()
    os.close(send)
    listener = Listener(receive)
    assert listener.wait(60.0) is None
    os.close(receive)
    assert listener.wait(0.01) is None
