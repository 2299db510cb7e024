"""The connection from the server to the standby worker."""

from __future__ import annotations

import os
import time

import pytest

from app.jobs import worker
from app.jobs.kinds import JobKinds
from app.jobs.wakeup import ExpectedJob, WakeupListener, WakeupSender


def test_a_call_ends_the_wait_and_the_newest_expected_job_counts() -> None:
    sender = WakeupSender()
    listener = WakeupListener(sender.receiver)
    try:
        assert listener.wait(0.0) is None
        sender.send()
        began = time.monotonic()
        assert listener.wait(60.0) is None
        assert time.monotonic() - began < 30
        sender.send(("follow", {"frame": 1}))
        sender.send()
        sender.send(("follow", {"frame": 2}))
        assert listener.wait(60.0) == ("follow", {"frame": 2})
    finally:
        sender.close()


def test_a_standby_worker_prepares_for_the_expected_job(monkeypatch: pytest.MonkeyPatch) -> None:
    sender = WakeupSender()
    heard: list[ExpectedJob] = []
    monkeypatch.setattr(worker, "WakeupListener", lambda: WakeupListener(sender.receiver))
    sender.send(("follow", {"frame": 7}))
    worker.work(lambda: False, heard.append, JobKinds([], worker="w"), lambda: bool(heard), is_standby=True)
    assert heard == [("follow", {"frame": 7})]
    sender.close()


def test_an_unresponsive_worker_blocks_nobody() -> None:
    sender = WakeupSender()
    try:
        for _ in range(5000):  # far more than the pipe's capacity
            sender.send(("follow", {"frame": 10**9}))
        assert WakeupListener(sender.receiver).wait(1.0) == ("follow", {"frame": 10**9})
    finally:
        sender.close()


def test_the_end_of_the_server_is_not_a_call() -> None:
    receive, send = os.pipe()
    os.close(send)
    listener = WakeupListener(receive)
    assert listener.wait(60.0) is None
    os.close(receive)
    assert listener.wait(0.01) is None
