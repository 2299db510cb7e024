"""Stores of earlier versions, whose tables lack columns that were added since."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.evidence.complete_run import write_complete_run
from tests.evidence.synthetic_evidence import make_frame
from tsr_engine.errors import EvidenceError
from tsr_engine.evidence import EvidenceReader, RunHeader
from tsr_engine.evidence.columns import read_columns
from tsr_engine.evidence.schema import BY_NAME, DATABASE
from tsr_engine.evidence.untrusted import check_untrusted


@pytest.fixture
def folder(tmp_path: Path, header: RunHeader) -> Path:
    """A run of a version in which ``track_frames`` had no ``detection`` and ``tracks`` ended with ``largest_side``."""
    write_complete_run(tmp_path / "run", header, [make_frame(k) for k in range(6)])
    drop_last_columns(tmp_path / "run" / DATABASE, "track_frames", 1)
    drop_last_columns(tmp_path / "run" / DATABASE, "tracks", 2)
    return tmp_path / "run"


def drop_last_columns(store: Path, name: str, columns: int) -> None:
    """Make the table as it was before its last columns were added."""
    table = BY_NAME[name]
    earlier = replace(table, columns=table.columns[:-columns])
    names = ", ".join(column for column, _, _ in earlier.columns)
    with closing(sqlite3.connect(store)) as connection:
        connection.execute(f"CREATE TEMP TABLE kept AS SELECT {names} FROM {name}")
        connection.execute(f"DROP TABLE {name}")
        for statement in earlier.statements():
            connection.execute(statement)
        connection.execute(f"INSERT INTO main.{name} SELECT * FROM kept")
        connection.commit()


def test_missing_columns_read_as_null(folder: Path) -> None:
    with EvidenceReader(folder) as run:
        for k, frame in enumerate(run.frames()):
            for found, made in zip(frame.tracks, make_frame(k).tracks, strict=True):
                assert (found.detection, found.score) == (None, made.score)
                assert np.array_equal(found.box, made.box)
        assert [track.class_id for track in run.tracks()] == [None] * len(list(run.tracks()))
        columns = read_columns(run, "track_frames", "score", "detection", "gates.l_positive", alive=True)
        assert not columns.has_value("detection").any()
        assert columns.has_value("score").all()


def test_a_bundle_may_have_the_columns_of_an_earlier_version(folder: Path) -> None:
    check_untrusted(folder / DATABASE, 6)


@pytest.mark.parametrize(
    "change",
    [
        "ALTER TABLE tracks ADD COLUMN later",
        "ALTER TABLE gates DROP COLUMN symmetry",
        "CREATE VIEW more AS SELECT 1",
        "DROP TABLE timings",
    ],
)
def test_a_bundle_may_have_no_other_difference(folder: Path, change: str) -> None:
    with closing(sqlite3.connect(folder / DATABASE)) as connection:
        connection.execute(change)
    with pytest.raises(EvidenceError, match="which is not ours|lacks a table"):
        check_untrusted(folder / DATABASE, 6)
