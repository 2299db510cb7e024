"""Answers about whole runs are computed once, however many clients ask, and before the first request."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any

import pytest

import app.evidence.service as service
from app.evidence.service import EvidenceService
from app.settings import Settings
from app.storage.database import Database
from tests.app import long_run


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Count computations of lanes and tracks."""
    calls: list[str] = []

    def counting(name: str) -> Any:
        plain = getattr(service, name)

        def slowly(reader: Any) -> Any:
            calls.append(name)
            time.sleep(0.2)
            return plain(reader)

        return slowly

    for name in ("lane_columns", "read_track_properties"):
        monkeypatch.setattr(service, name, counting(name))
    return calls


def test_simultaneous_requests_share_one_computation(tmp_path: Path, counted: list[str]) -> None:
    made = long_run.make_long_run(tmp_path, frames=200, tracks=6)
    settings = Settings(home=tmp_path)
    database = Database(settings.database)
    evidence = EvidenceService(settings, database)
    answers: list[bytes] = []
    threads = [threading.Thread(target=lambda: answers.append(evidence.lanes(made.run_id))) for _ in range(5)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30)
    assert len(answers) == 5
    assert len(set(answers)) == 1
    assert counted == ["lane_columns"]
    evidence.close()
    database.close()


def test_the_newest_run_is_computed_before_it_is_opened(tmp_path: Path, counted: list[str]) -> None:
    settings = Settings(home=tmp_path)
    made = long_run.make_long_run(tmp_path, frames=200, tracks=6)
    database = Database(settings.database)
    evidence = EvidenceService(settings, database)
    evidence.warm()
    assert sorted(counted) == ["lane_columns", "read_track_properties"]
    evidence.lanes(made.run_id)
    evidence.tracks(made.run_id)
    assert len(counted) == 2
    evidence.close()
    database.close()


def test_a_library_without_runs_needs_no_preparation(tmp_path: Path) -> None:
    settings = Settings(home=tmp_path)
    database = Database(settings.database)
    database.migrate(tmp_path / "backups")
    evidence = EvidenceService(settings, database)
    evidence.warm()
    evidence.close()
    database.close()
