"""Evidence of runs that failed, were interrupted or filled the disk, and damaged evidence."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from tests.evidence.complete_run import write_complete_run
from tests.evidence.synthetic_evidence import make_frame, make_header
from tsr_engine.errors import EvidenceError, StorageError
from tsr_engine.evidence import EvidenceReader, EvidenceWriter, RunHeader, TableEntry, differences
from tsr_engine.evidence import writer as writer_module
from tsr_engine.evidence.encode import add_rows
from tsr_engine.records import FrameEvidence


def test_an_exception_closes_the_run_as_failed(folder: Path, header: RunHeader) -> None:
    def run_and_fail() -> None:
        with EvidenceWriter.create(folder, header) as writer:
            writer.append(make_frame(0))
            raise RuntimeError("the decoder gave up")

    with pytest.raises(RuntimeError):
        run_and_fail()
    with EvidenceReader(folder) as run:
        assert (run.state, run.header.reason, len(run)) == ("failed", "the decoder gave up", 1)


@pytest.mark.parametrize("where", ["half a frame", "the frame's summaries", "behind the commit"])
def test_ctrl_c_within_a_frame_leaves_no_partial_frame(
    folder: Path, header: RunHeader, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = [make_frame(k) for k in range(24)]

    def half(rows: dict[str, list[Any]], evidence: FrameEvidence, entry: TableEntry, keep_pixels: bool) -> None:
        add_rows(rows, evidence, entry, keep_pixels)
        if evidence.ordinal == 15:
            rows["track_frames"].pop()
            raise KeyboardInterrupt

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    def run() -> None:
        with EvidenceWriter.create(folder, header, chunk=4) as writer:
            for evidence in frames[:15]:
                writer.append(evidence)
            if where == "half a frame":
                monkeypatch.setattr(writer_module, "add_rows", half)
            elif where == "the frame's summaries":
                monkeypatch.setattr(writer, "_summarise", interrupted)
            else:
                monkeypatch.setattr(writer_module, "_empty_rows", interrupted)
            writer.append(frames[15])

    with pytest.raises(KeyboardInterrupt):
        run()
    monkeypatch.undo()
    with EvidenceReader(folder) as stored:
        kept = len(stored)
        assert stored.state == "interrupted"
        assert kept in (12, 16)
        assert [d for a, b in zip(frames, stored.frames(), strict=False) for d in differences(a, b)] == []
    with EvidenceWriter.resume(folder, header) as writer:
        for evidence in frames[kept:]:
            writer.append(evidence)
    write_complete_run(folder.with_name("whole"), header, frames)
    with EvidenceReader(folder) as stored, EvidenceReader(folder.with_name("whole")) as whole:
        assert list(stored.tracks()) == list(whole.tracks())
        assert [d for a, b in zip(whole.frames(), stored.frames(), strict=True) for d in differences(a, b)] == []


def test_damage_is_named(folder: Path, header: RunHeader) -> None:
    with pytest.raises(EvidenceError, match=r"no evidence folder: run\.json is missing"):
        EvidenceReader(folder)
    write_complete_run(folder, header, [make_frame(k) for k in range(50)])
    database, run_file = folder / "evidence.sqlite", folder / "run.json"
    content, text = database.read_bytes(), run_file.read_text()

    run_file.write_text(text.replace('"schema_version": 1', '"schema_version": 7'))
    with pytest.raises(EvidenceError, match=r"evidence schema 7, this version reads schema 1\. Update"):
        EvidenceReader(folder)
    for broken in (
        "",
        "[]",
        "{",
        json.dumps({"schema_version": 1}),
        text.replace("15.0", "16.0"),
        "\0\xff",
        "[" * 100_000,
    ):
        run_file.write_text(broken)
        with pytest.raises(EvidenceError, match="is damaged"):
            EvidenceReader(folder)
    run_file.write_text(text)

    database.write_bytes(b"not a database at all" * 100)
    with pytest.raises(EvidenceError, match=r"Cannot read|is damaged"):
        EvidenceReader(folder)
    with pytest.raises(EvidenceError, match="is damaged"):
        EvidenceWriter.resume(folder, header)
    database.write_bytes(content[: len(content) // 2])
    with pytest.raises(EvidenceError), EvidenceReader(folder) as run:
        list(run.frames())
    database.unlink()
    with pytest.raises(EvidenceError, match="is missing"):
        EvidenceReader(folder)
    sqlite3.connect(database).close()
    with pytest.raises(EvidenceError, match="is damaged"):
        EvidenceReader(folder)


def test_facts_that_are_nested_too_deeply_are_damage(folder: Path, header: RunHeader) -> None:
    write_complete_run(folder, header, [make_frame(k) for k in range(4)])
    with closing(sqlite3.connect(folder / "evidence.sqlite")) as store, store:
        store.execute("UPDATE events SET facts = ?", ("[" * 100_000,))
    with EvidenceReader(folder) as run, pytest.raises(EvidenceError, match="is damaged"):
        list(run.frames())


def test_a_database_of_another_run_is_refused(folder: Path) -> None:
    write_complete_run(folder, make_header(), [make_frame(0)])
    other = folder.parent / "other"
    write_complete_run(other, make_header(models={}), [make_frame(0)])
    (folder / "evidence.sqlite").write_bytes((other / "evidence.sqlite").read_bytes())
    with pytest.raises(EvidenceError, match=r"does not belong to the run\.json"):
        EvidenceReader(folder)


def test_a_full_database_keeps_what_was_committed(folder: Path, header: RunHeader) -> None:
    frames = [make_frame(k) for k in range(400)]
    writer = EvidenceWriter.create(folder, header, chunk=10)
    pages = writer._connection.execute("PRAGMA page_count").fetchone()[0]
    writer._connection.execute(f"PRAGMA max_page_count = {pages + 20}")

    def fill() -> None:
        for evidence in frames:
            writer.append(evidence)

    with pytest.raises(StorageError, match="full"):
        fill()
    with pytest.raises(StorageError):
        writer.close()
    with EvidenceReader(folder) as run:
        kept = len(run)
        assert kept % 10 == 0
        assert 0 < kept < 400
        assert [d for a, b in zip(frames, run.frames(), strict=False) for d in differences(a, b)] == []
        assert run.state == "interrupted"
    with EvidenceWriter.resume(folder, header) as writer:
        for evidence in frames[kept:]:
            writer.append(evidence)
    with EvidenceReader(folder) as run:
        assert len(run) == 400


def test_a_folder_that_cannot_be_created(tmp_path: Path, header: RunHeader) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StorageError, match="Cannot write the evidence"):
        EvidenceWriter.create(tmp_path / "file" / "run", header)
