"""Containers and cloned machines of equal names do not declare each other's jobs dead."""

from __future__ import annotations

import shutil
import socket
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from app.events import EventBus
from app.job_kinds import KINDS
from app.jobs.queue import JobQueue
from app.jobs.supervisor import Supervisor
from app.settings import Settings
from app.storage import identity
from app.storage.database import Database
from app.storage.identity import lock_place, server_id
from tests.app.databases import new_database
from tsr_engine.errors import StorageError


def test_a_home_has_a_unique_lasting_id(tmp_path: Path) -> None:
    one, other = tmp_path / "one", tmp_path / "other"
    with ThreadPoolExecutor(8) as pool:
        assert len(set(pool.map(lambda _: server_id(one), range(32)))) == 1
    assert server_id(one) != server_id(other)
    assert sorted(path.name for path in one.iterdir()) == ["server.id"]
    (one / "server.id").write_text("nonsense")
    with pytest.raises(StorageError, match="does not contain an id"):
        server_id(one)


def test_a_copy_a_clone_and_a_container_have_other_ids(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(socket, "gethostname", lambda: "tsr")
    home = tmp_path / "home"
    place = lock_place(home)
    assert place is not None
    assert lock_place(home) == place
    shutil.copytree(home, tmp_path / "copy")
    assert server_id(tmp_path / "copy") == server_id(home)
    assert lock_place(tmp_path / "copy") != place
    boot = tmp_path / "boot"
    boot.write_text("another life of the kernel\n")
    monkeypatch.setattr(identity, "BOOT_ID_FILE", boot)
    assert lock_place(home) != place
    monkeypatch.setattr(identity, "BOOT_ID_FILE", tmp_path / "none")
    assert lock_place(home) is None


@pytest.mark.parametrize("twin", ["copy", "clone", "untold"])
def test_a_server_with_the_same_name_does_not_fail_running_jobs(
    cluster: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, twin: str
) -> None:
    """The other server's supervisor sees the job; it stays alive as long as its heartbeat is recent."""
    monkeypatch.setattr(socket, "gethostname", lambda: "tsr")
    now = 0.0
    shared, jobs, home = Database(new_database(cluster)), JobQueue(EventBus(), KINDS), tmp_path / "home"
    shared.migrate()
    place = lock_place(home)
    if twin == "copy":
        shutil.copytree(home, tmp_path / "copy")
        home = tmp_path / "copy"
    else:
        boot = tmp_path / "boot"
        boot.write_text("another" if twin == "clone" else "")
        monkeypatch.setattr(identity, "BOOT_ID_FILE", boot)
    supervisor = Supervisor(Settings(home=home), shared, jobs, clock=lambda: now)
    with shared.write() as session:
        job = jobs.claim(session, jobs.submit(session, "track", "s" * 32).id, place or "")
    assert job is not None
    assert not supervisor.is_dead(job)
    now += 0.9 * supervisor.heartbeat_timeout
    assert not supervisor.is_dead(job)
    now += 0.2 * supervisor.heartbeat_timeout
    assert supervisor.is_dead(job)
    shared.close()
