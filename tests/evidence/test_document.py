"""docs/evidence.md describes the store's actual schema."""

from __future__ import annotations

import re
import sqlite3
from contextlib import closing
from dataclasses import fields
from pathlib import Path

from tsr_engine import evidence
from tsr_engine.evidence import SCHEMA_VERSION, EvidenceWriter, RunHeader
from tsr_engine.evidence.schema import DATABASE, TABLES

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "evidence.md"


def documented() -> dict[str, dict[str, str]]:
    """Table -> column -> meaning, from the document."""
    tables: dict[str, dict[str, str]] = {}
    for section in re.split(r"^### ", DOCUMENT.read_text(encoding="utf-8"), flags=re.M)[1:]:
        name = section.split("`")[1]
        rows = re.findall(r"^\| `(\w+)` \| [\w ]+ \| (.+) \|$", section.split("\n## ")[0], flags=re.M)
        tables[name] = dict(rows)
    return tables


def test_every_table_and_column_is_documented_with_its_meaning() -> None:
    assert documented() == {t.name: {name: meaning for name, _, meaning in t.columns} for t in TABLES}
    assert f"Schema version: **{SCHEMA_VERSION}**" in DOCUMENT.read_text(encoding="utf-8")


def test_named_methods_exist() -> None:
    named = re.findall(r"`(Evidence\w+)\.(\w+)", DOCUMENT.read_text(encoding="utf-8"))
    assert len(named) >= 2
    assert [f"{owner}.{name}" for owner, name in named if not hasattr(getattr(evidence, owner), name)] == []


def test_the_store_has_the_documented_tables(folder: Path, header: RunHeader) -> None:
    EvidenceWriter.create(folder, header).close()
    with closing(sqlite3.connect(folder / DATABASE)) as store:
        names = store.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall()
        real = {n: [c[1] for c in store.execute(f"PRAGMA table_info({n})")] for (n,) in names}
    assert real == {name: list(columns) for name, columns in documented().items()}


def test_queries_by_frame_and_by_track_use_an_index(folder: Path, header: RunHeader) -> None:
    EvidenceWriter.create(folder, header).close()
    store = sqlite3.connect(folder / DATABASE)

    def plan(sql: str) -> str:
        return " ".join(row[3] for row in store.execute(f"EXPLAIN QUERY PLAN {sql}"))

    for table in TABLES:
        if table.name not in ("meta", "tracks"):
            steps = plan(f"SELECT * FROM {table.name} WHERE frame >= 5 AND frame < 9")
            assert steps.startswith("SEARCH"), steps
    assert "track_frames_by_track" in plan("SELECT min(frame), max(frame) FROM track_frames WHERE track_id = 4")
    assert "events_by_track" in plan("SELECT * FROM events WHERE track_id = 4")
    assert "quiet_frames" in plan("SELECT max(frame) FROM frames WHERE alive = 0 AND frame < 900")
    store.close()


def test_run_json_holds_every_field_of_the_header(folder: Path, header: RunHeader) -> None:
    EvidenceWriter.create(folder, header).close()
    text = (folder / "run.json").read_text()
    usual = {"labels"}  # only for a model with other than the usual classes
    assert all((f'"{field.name}"' in text) == (field.name not in usual) for field in fields(RunHeader))
