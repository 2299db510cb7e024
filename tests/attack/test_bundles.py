"""Bundles whose evidence computes forever, and checkers that would outlive their client (finding F6)."""

from __future__ import annotations

import sqlite3
import threading
import time
import zipfile
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from app.errors import Busy
from app.sandbox.limits import Limits
from app.sandbox.sandboxes import Sandboxes
from tests.app.bundles.toy_bundle import ToyBundle, bundled, server
from tests.app.toy_server import Server
from tests.attack.damage import fix_manifest, zipped
from tests.waiting import time_limit, wait_until
from tsr_engine.errors import EvidenceError
from tsr_engine.evidence.schema import create_tables
from tsr_engine.evidence.untrusted import check_untrusted

__all__ = ["bundled", "server"]

ENDLESS = "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT x FROM n"
VIEW = f"CREATE VIEW timings (frame, row, stage, seconds) AS SELECT x, x, 'a', 1.0 FROM ({ENDLESS})"
FORGED = {
    "an endless view": f"DROP TABLE timings; {VIEW}",
    "one more view": f"CREATE VIEW more AS {ENDLESS}",
    "a trigger": "CREATE TRIGGER t AFTER INSERT ON frames BEGIN SELECT 1; END",
    "one more table": "CREATE TABLE more (x)",
    "a virtual table": "CREATE VIRTUAL TABLE more USING fts5(x)",
    "a generated column": "ALTER TABLE timings ADD COLUMN more AS (hex(zeroblob(100000000))) VIRTUAL",
    "one more column": "ALTER TABLE timings ADD COLUMN more DEFAULT 1",
    "a computed index": "CREATE INDEX more ON timings (hex(stage))",
    "no table": "DROP TABLE timings",
}


def rewritten(plain: Path, out: Path, change: Callable[[Path], None]) -> Path:
    """A bundle with changed evidence and correct hashes."""
    with zipfile.ZipFile(plain) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    store = out.with_suffix(".sqlite")
    store.write_bytes(content["evidence/evidence.sqlite"])
    change(store)
    content["evidence/evidence.sqlite"] = store.read_bytes()
    fix_manifest(content)
    out.write_bytes(zipped(content))
    return out


def forge(script: str) -> Callable[[Path], None]:
    def change(store: Path) -> None:
        with closing(sqlite3.connect(store)) as connection:
            connection.executescript(script)

    return change


@pytest.mark.parametrize("script", FORGED.values(), ids=FORGED)
def test_forged_evidence_is_refused_at_once(bundled: ToyBundle, server: Server, tmp_path: Path, script: str) -> None:
    forged = rewritten(bundled.path, tmp_path / "forged.zip", forge(script))
    began = time.monotonic()
    answer = server.client.post("/api/bundles", content=forged.read_bytes())
    assert answer.status_code == 422, answer.text
    assert "which is not ours" in answer.json()["error"]["message"] or "lacks a table" in answer.text
    assert time.monotonic() - began < time_limit(5)


def test_a_cyclic_page_is_refused(tmp_path: Path) -> None:
    store = tmp_path / "evidence.sqlite"
    with closing(sqlite3.connect(store)) as connection:
        connection.execute("PRAGMA page_size = 512")
        create_tables(connection)
        connection.executemany("INSERT INTO timings VALUES (?, 0, ?, 0.5)", ((k, "x" * 90) for k in range(400)))
        connection.commit()
        root = connection.execute("SELECT rootpage FROM sqlite_master WHERE name = 'timings'").fetchone()[0]
    data = bytearray(store.read_bytes())
    page = (root - 1) * 512
    assert data[page] == 2, "the root of timings must be an inner page"
    cells = int.from_bytes(data[page + 3 : page + 5], "big")
    first = int.from_bytes(data[page + 12 : page + 14], "big")
    for cell in range(cells):  # all children are the root
        at = int.from_bytes(data[page + 12 + 2 * cell : page + 14 + 2 * cell], "big")
        data[page + at : page + at + 4] = root.to_bytes(4, "big")
    assert first
    data[page + 8 : page + 12] = root.to_bytes(4, "big")
    store.write_bytes(data)
    began = time.monotonic()
    with pytest.raises(EvidenceError):
        check_untrusted(store, 400)
    assert time.monotonic() - began < time_limit(5)


def test_more_rows_than_the_clip_has_frames(tmp_path: Path) -> None:
    store = tmp_path / "evidence.sqlite"
    with closing(sqlite3.connect(store)) as connection:
        create_tables(connection)
        connection.executemany("INSERT INTO timings VALUES (0, ?, 'a', 0.5)", ((row,) for row in range(9000)))
        connection.commit()
    check_untrusted(store, 75)
    with pytest.raises(EvidenceError, match="9000 rows in timings, more than 3 frames"):
        check_untrusted(store, 3)


def endless_check(_: Any, path: Path, folder: Path, *__: Any) -> None:
    """A check that never ends, in place of the check of bundles."""
    (folder / "begun").write_text(path.name)
    while True:
        pass


def test_the_check_ends_when_the_client_leaves(bundled: ToyBundle, server: Server, tmp_path: Path) -> None:
    imports, left = server.context.bundle_imports, threading.Event()
    imports._sandboxes = EndlessSandboxes(imports._sandboxes)  # type: ignore[assignment]
    (work := tmp_path / "work").mkdir()
    failed: list[BaseException] = []

    def bring_in() -> None:
        try:
            imports.import_bundle(bundled.path, work, "ada", left.is_set)
        except Busy as error:
            failed.append(error)

    thread = threading.Thread(target=bring_in)
    thread.start()
    wait_until((work / "begun").exists, time_limit(10))
    began = time.monotonic()
    left.set()
    thread.join(time_limit(2))
    assert not thread.is_alive()
    assert time.monotonic() - began < time_limit(1)
    assert failed


class EndlessSandboxes:
    """Sandboxes in which the check of a bundle never ends."""

    def __init__(self, sandboxes: Sandboxes) -> None:
        self._sandboxes = sandboxes

    def run(self, _: str, *arguments: Any, limits: Limits, **more: Any) -> Any:
        return self._sandboxes.run("tests.attack.test_bundles:endless_check", *arguments, limits=limits, **more)
