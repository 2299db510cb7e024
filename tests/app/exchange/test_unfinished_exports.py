"""Exports that wait, run, fail, are cancelled, or lose their worker or their run."""

from __future__ import annotations

import errno
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from app.jobs.context import Stopped, TaskContext
from app.jobs.outcome import end_stopped_task
from app.outputs.folders import output_folder
from app.outputs.service import OutputService
from app.storage.models import Job, Output
from tests.app.exchange.exchange_desk import Desk, unzipped
from tests.app.import_now import work_off
from tests.patience import within


def queued(desk: Desk, **request: Any) -> str:
    """An export that no worker has started."""
    asked = {"runs": [desk.run_id], "format": "cvat-video", "states": ["open"], **request}
    return str(desk.post("/api/exports", asked)["id"])


@contextmanager
def claimed(desk: Desk) -> Iterator[TaskContext]:
    """The next job, claimed by a fictitious worker."""
    c = desk.server.context
    with c.database.write() as session:
        job = c.jobs.claim(session, c.jobs.waiting_ids(session)[0])
    assert job is not None
    yield TaskContext(c.settings, c.database, c.events, c.jobs, job, lambda: False)


def test_a_failed_export_says_why_and_leaves_nothing(desk: Desk) -> None:
    output = desk.export(states=["accepted"], first=74, stop=75, split={"train": 1, "val": 1})
    assert output["state"] == "failed"
    assert "too few" in output["error"]
    answer = desk.server.client.get(f"/api/outputs/{output['id']}/download")
    assert answer.status_code == 409
    assert desk.output_files() == []


def test_a_full_disk_is_reported_and_leaves_nothing(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_file: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("tsr_engine.exchange.publish.os.fsync", full)
    output = desk.export()
    assert output["state"] == "failed"
    assert "disk is full" in output["error"]
    assert desk.output_files() == []


def test_a_waiting_export_is_cancelled_at_once(desk: Desk) -> None:
    output = queued(desk)
    answer = desk.post(f"/api/outputs/{output}/cancel")
    assert answer["state"] == "cancelled"
    work_off(desk.server.context)
    assert desk.get(f"/api/outputs/{output}")["state"] == "cancelled"
    assert desk.post(f"/api/outputs/{output}/cancel")["state"] == "cancelled", "again: nothing happens"


def test_a_running_export_is_cancelled(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.outputs.service.PROGRESS_INTERVAL_S", 0.0)
    output = queued(desk)
    with claimed(desk) as task:
        desk.post(f"/api/outputs/{output}/cancel")
        assert desk.get(f"/api/outputs/{output}")["state"] == "queued", "its worker has to see it first"
        with pytest.raises(Stopped):
            task.jobs.kinds.load_task("export")(task)
        end_stopped_task(task)
    assert desk.get(f"/api/outputs/{output}")["state"] == "cancelled"
    assert desk.output_files() == []


def test_an_export_that_is_cancelled_at_its_end_is_not_completed(desk: Desk) -> None:
    output = queued(desk)
    with claimed(desk) as task:
        service, row, folder = OutputService.begin(task)
        (folder / "export.zip").write_bytes(b"whole")
        desk.post(f"/api/outputs/{output}/cancel")
        with pytest.raises(Stopped):
            service.complete(task, row.id, folder / "export.zip", {})
        end_stopped_task(task)
    assert desk.get(f"/api/outputs/{output}")["state"] == "cancelled"
    assert desk.output_files() == []


def test_a_running_export_cannot_be_removed(desk: Desk) -> None:
    output = queued(desk)
    answer = desk.server.client.delete(f"/api/outputs/{output}")
    assert answer.status_code == 409
    work_off(desk.server.context)
    assert desk.server.client.delete(f"/api/outputs/{output}").status_code == 204
    assert desk.output_files() == []
    assert desk.server.client.get(f"/api/outputs/{output}").status_code == 404


def test_a_dead_worker_leaves_nothing_in_the_next_export(desk: Desk) -> None:
    output = queued(desk)
    c = desk.server.context
    with claimed(desk) as task:
        _, _, folder = OutputService.begin(task)
        (folder / ".export.zip.0123456789abcdef.part").mkdir()
        (folder / "export.zip").write_bytes(b"half")
        with c.database.write() as session:
            assert c.jobs.requeue_dead(session, task.job.id, task.job.token) is None
    work_off(c)
    view = desk.get(f"/api/outputs/{output}")
    assert view["state"] == "complete"
    assert [path.name for path in desk.output_files()] == [output, "export.zip"]
    assert "annotations.xml" in unzipped(desk.download(view))


def test_the_start_of_a_server_removes_abandoned_files(desk: Desk) -> None:
    kept, gone = desk.export()["id"], queued(desk)
    desk.post(f"/api/outputs/{gone}/cancel")
    for name in (gone, "f" * 32):
        output_folder(desk.home, name).mkdir(parents=True)
        (output_folder(desk.home, name) / "half").write_bytes(b"x")
    desk.server.context.outputs.sweep()
    assert [path.name for path in (desk.home / "artefacts").iterdir()] == [kept]


def test_an_export_of_a_removed_run_fails_with_a_sentence(desk: Desk) -> None:
    output = queued(desk)
    desk.server.client.delete(f"/api/runs/{desk.run_id}")
    work_off(desk.server.context)
    view = desk.get(f"/api/outputs/{output}")
    assert view["state"] == "failed"
    assert view["error"] == "The run has been removed in the meantime."


def test_progress_events_are_limited(desk: Desk) -> None:
    queued(desk)
    with claimed(desk) as task:
        service, output, _ = OutputService.begin(task)
        began = time.monotonic()
        for done in range(5000):
            service.progress(task, output.id, done, 5000)
        assert time.monotonic() - began < within(3)
        with task.database.read() as session:
            assert session.get_one(Output, output.id).total == 5000
            assert session.get_one(Job, task.job.id).state == "running"
