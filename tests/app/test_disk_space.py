"""A full disk and its end are reported to every page, also to pages opened later."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import requests

from app import startup
from app.storage.disk_space import MIN_FREE_BYTES, shortage
from tests.app.threaded_server import ThreadedServer, serve_in_thread
from tests.app.toy_server import SECRET, Server

FULL = "The disk of the data folder is full: 0 MiB are left."


def test_a_full_disk_has_a_message_while_it_lasts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert shortage(tmp_path / "missing") is None
    for free, said in ((MIN_FREE_BYTES, False), (MIN_FREE_BYTES - 1, True), (0, True)):
        monkeypatch.setattr(shutil, "disk_usage", lambda _, free=free: SimpleNamespace(free=free))
        assert (shortage(tmp_path) is not None) == said
    assert (shortage(tmp_path) or "").startswith(FULL)


def messages(at: ThreadedServer) -> Iterator[tuple[str, Any]]:
    answer = requests.get(
        f"{at.url}/api/events", headers={"Authorization": f"Bearer {SECRET}"}, stream=True, timeout=15
    )
    with closing(answer):
        found: dict[str, str] = {}
        for line in answer.iter_lines(chunk_size=None, decode_unicode=True):
            if line:
                name, _, value = line.partition(": ")
                found[name] = value
            elif "data" in found:
                yield found["event"], json.loads(found["data"])
                found = {}


def test_pages_are_notified_of_a_full_disk_and_its_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str | None] = [None]
    monkeypatch.setattr(startup, "shortage", lambda _home: said[-1])
    with serve_in_thread(Server(tmp_path / "home")) as at, closing(messages(at)) as page:
        assert next(page)[0] == "hello"
        said.append(FULL)
        assert next(page) == ("storage", {"text": FULL})
        with closing(messages(at)) as late:
            assert next(late)[0] == "hello"
            assert next(late) == ("storage", {"text": FULL})
        said.append(None)
        assert next(page) == ("storage", {"text": None})
        context = at.server.context
        with context.database.write() as session:
            context.events.publish(session, "test", "subject", {})
        assert next(page)[0] == "change", "the numbered stream goes on beside it"
