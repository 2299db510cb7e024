"""Checks an untrusted evidence store before the first query.

SQLite executes the schema of a file: a view in place of a table can compute without end, a generated column or a
trigger calls functions, and a tree page that refers to itself gives endless rows. So the schema must equal ours
exactly, except for columns that earlier versions lack, and the trees must be sound.
"""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Final

from tsr_engine.errors import EvidenceError
from tsr_engine.evidence.earlier_versions import earlier_column_count
from tsr_engine.evidence.schema import BY_NAME, TABLES, create_tables

_MAX_STEPS: Final = 20_000_000
"""Most steps of SQLite's virtual machine for this check; a run of 3,000 frames takes a hundredth."""
_STEPS_PER_CHECK: Final = 10_000
_MAX_ROWS_PER_FRAME: Final = 2000
"""Most rows of one frame in one table; the busiest real frames have some hundred."""
_SCHEMA_QUERY: Final = "SELECT type, name, tbl_name, sql FROM sqlite_master ORDER BY type, name"


def check_untrusted(path: Path, frames: int) -> None:
    """Refuse a store with objects other than our tables, or with more rows than its frames can have.

    Args:
        path: the SQLite file; nothing else writes it.
        frames: stated number of frames.

    Raises:
        EvidenceError: names the offending content.
    """
    checks_left = _MAX_STEPS // _STEPS_PER_CHECK

    def count_down() -> int:
        nonlocal checks_left
        checks_left -= 1
        return checks_left < 0

    address = f"{path.resolve().as_uri()}?mode=ro&immutable=1"
    try:
        with closing(sqlite3.connect(address, uri=True, isolation_level=None)) as store:
            store.set_progress_handler(count_down, _STEPS_PER_CHECK)
            store.execute("PRAGMA trusted_schema = OFF")
            store.execute("PRAGMA cell_size_check = ON")
            _check_schema(path, store)
            if store.execute("PRAGMA quick_check(1)").fetchone() != ("ok",):
                raise EvidenceError(f"{path.name} is damaged. Copy the file that it came in again.")
            for table in TABLES:
                count = store.execute(f"SELECT count(*) FROM {table.name}").fetchone()[0]  # noqa: S608 - our own names
                if count > _MAX_ROWS_PER_FRAME * (frames + 1):
                    raise EvidenceError(
                        f"{path.name} has {count} rows in {table.name}, more than {frames} frames can have."
                    )
    except sqlite3.OperationalError as error:
        if checks_left < 0:
            raise EvidenceError(f"{path.name} takes too long to check for {frames} frames.") from None
        raise EvidenceError(f"{path.name} cannot be read: {error}.") from None
    except sqlite3.DatabaseError as error:
        raise EvidenceError(f"{path.name} cannot be read: {error}.") from None


def _check_schema(path: Path, store: sqlite3.Connection) -> None:
    with closing(sqlite3.connect(":memory:")) as reference:
        create_tables(reference)
        known = reference.execute(_SCHEMA_QUERY).fetchall()
    # One row more than ours is enough to detect a difference.
    found = store.execute(f"{_SCHEMA_QUERY} LIMIT {len(known) + 1}").fetchall()
    if len(found) == len(known) and all(
        row == known_row or (row[:3] == known_row[:3] and _is_earlier(row))
        for row, known_row in zip(found, known, strict=True)
    ):
        return
    other = next((row for row in found if row not in known and not _is_earlier(row)), None)
    difference = (
        "lacks a table" if other is None else f"has the {str(other[0])[:20]} {str(other[1])[:60]!r}, which is not ours"
    )
    raise EvidenceError(f"{path.name} {difference}. Create it again with this version.")


def _is_earlier(row: tuple[str, str, str, str | None]) -> bool:
    """Whether a row of the schema is one of our tables without the columns that were added since."""
    kind, name, _, statement = row
    return kind == "table" and name in BY_NAME and earlier_column_count(BY_NAME[name], statement or "") is not None
