"""Exports that wait, run, fail, are cancelled, or lose their worker or their run."""

from __future__ import annotations

import errno
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from app.job_kinds import KINDS
from app.jobs.context import Stopped, TaskContext
from app.jobs.outcome import end_stopped_task
from app.jobs.worker import perform
from app.outputs.folders import output_folder
from app.outputs.service import OutputService
from app.storage.models import Job, Output
from tests.app.exchange.exchange_client import ExchangeClient, unzipped
from tests.app.inline_worker import run_jobs
from tests.waiting import time_limit


def queued(api: ExchangeClient, **request: Any) -> str:
    """An export that no worker has started."""
    asked = {"runs": [api.run_id], "format": "cvat-video", "states": ["open"], **request}
    return str(api.post("/api/exports", asked)["id"])


@contextmanager
def claim_job(api: ExchangeClient) -> Iterator[TaskContext]:
    """The next job, claimed by a fictitious worker."""
    c = api.server.context
    with c.database.write() as session:
        job = c.jobs.claim(session, c.jobs.waiting_ids(session)[0])
    assert job is not None
    yield TaskContext(c.settings, c.database, c.events, c.jobs, job, lambda: False)


def test_a_failed_export_says_why_and_leaves_nothing(api: ExchangeClient) -> None:
    output = api.export(states=["accepted"], first=74, stop=75, split={"train": 1, "val": 1})
    assert output["state"] == "failed"
    assert "too few" in output["error"]
    answer = api.server.client.get(f"/api/outputs/{output['id']}/download")
    assert answer.status_code == 409
    assert api.output_files() == []


def test_a_full_disk_is_reported_and_leaves_nothing(api: ExchangeClient, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_file: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("tsr_engine.exchange.publish.os.fsync", full)
    output = api.export()
    assert output["state"] == "failed"
    assert "disk is full" in output["error"]
    assert api.output_files() == []


def test_a_waiting_export_is_cancelled_at_once(api: ExchangeClient) -> None:
    output = queued(api)
    answer = api.post(f"/api/outputs/{output}/cancel")
    assert answer["state"] == "cancelled"
    run_jobs(api.server.context)
    assert api.get(f"/api/outputs/{output}")["state"] == "cancelled"
    assert api.post(f"/api/outputs/{output}/cancel")["state"] == "cancelled", "again: nothing happens"


def test_a_running_export_is_cancelled(api: ExchangeClient, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.outputs.service.PROGRESS_INTERVAL_S", 0.0)
    output = queued(api)
    with claim_job(api) as task:
        api.post(f"/api/outputs/{output}/cancel")
        assert api.get(f"/api/outputs/{output}")["state"] == "queued", "its worker has to see it first"
        with pytest.raises(Stopped):
            perform(task, KINDS)
        end_stopped_task(task)
    assert api.get(f"/api/outputs/{output}")["state"] == "cancelled"
    assert api.output_files() == []


def test_an_export_that_is_cancelled_at_its_end_is_not_completed(api: ExchangeClient) -> None:
    output = queued(api)
    with claim_job(api) as task:
        service, row, folder = OutputService.begin(task)
        (folder / "export.zip").write_bytes(b"whole")
        api.post(f"/api/outputs/{output}/cancel")
        with pytest.raises(Stopped):
            service.complete(task, row.id, folder / "export.zip", {})
        end_stopped_task(task)
    assert api.get(f"/api/outputs/{output}")["state"] == "cancelled"
    assert api.output_files() == []


def test_a_running_export_cannot_be_removed(api: ExchangeClient) -> None:
    output = queued(api)
    answer = api.server.client.delete(f"/api/outputs/{output}")
    assert answer.status_code == 409
    run_jobs(api.server.context)
    assert api.server.client.delete(f"/api/outputs/{output}").status_code == 204
    assert api.output_files() == []
    assert api.server.client.get(f"/api/outputs/{output}").status_code == 404


def test_a_dead_worker_leaves_nothing_in_the_next_export(api: ExchangeClient) -> None:
    output = queued(api)
    c = api.server.context
    with claim_job(api) as task:
        _, _, folder = OutputService.begin(task)
        (folder / ".export.zip.0123456789abcdef.part").mkdir()
        (folder / "export.zip").write_bytes(b"half")
        with c.database.write() as session:
            assert c.jobs.requeue_dead(session, task.job.id, task.job.token) is None
    run_jobs(c)
    view = api.get(f"/api/outputs/{output}")
    assert view["state"] == "complete"
    assert [path.name for path in api.output_files()] == [output, "export.zip"]
    assert "annotations.xml" in unzipped(api.download(view))


def test_the_start_of_a_server_removes_abandoned_files(api: ExchangeClient) -> None:
    kept, gone = api.export()["id"], queued(api)
    api.post(f"/api/outputs/{gone}/cancel")
    for name in (gone, "f" * 32):
        output_folder(api.home, name).mkdir(parents=True)
        (output_folder(api.home, name) / "half").write_bytes(b"x")
    api.server.context.outputs.sweep()
    assert [path.name for path in (api.home / "artefacts").iterdir()] == [kept]


def test_an_export_of_a_removed_run_fails_with_a_sentence(api: ExchangeClient) -> None:
    output = queued(api)
    api.server.client.delete(f"/api/runs/{api.run_id}")
    run_jobs(api.server.context)
    view = api.get(f"/api/outputs/{output}")
    assert view["state"] == "failed"
    assert view["error"] == "The run has been removed in the meantime."


def test_progress_events_are_limited(api: ExchangeClient) -> None:
    queued(api)
    with claim_job(api) as task:
        service, output, _ = OutputService.begin(task)
        began = time.monotonic()
        for done in range(5000):
            service.progress(task, output.id, done, 5000)
        assert time.monotonic() - began < time_limit(3)
        with task.database.read() as session:
            assert session.get_one(Output, output.id).total == 5000
            assert session.get_one(Job, task.job.id).state == "running"
