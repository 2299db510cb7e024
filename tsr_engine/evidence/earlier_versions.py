"""Reads stores of earlier versions, whose tables lack the columns that were added since.

Columns are only ever added at the end of a table, and allow NULL. A missing column reads as NULL. Such a run is never
continued: another version of the engine refuses to resume it.
"""

from __future__ import annotations

import sqlite3
from dataclasses import replace

from tsr_engine.evidence.schema import TABLES, Table


def read_missing_as_null(store: sqlite3.Connection) -> None:
    """Let the queries of a connection read missing columns as NULL.

    A temporary view, which the file does not contain, takes the name of each table that lacks columns.

    Raises:
        sqlite3.DatabaseError: the store cannot be read.
    """
    statements = dict(store.execute("SELECT name, sql FROM sqlite_master WHERE type = 'table'"))
    for table in TABLES:
        width = earlier_column_count(table, statements.get(table.name, ""))
        if width is not None:
            added = ", ".join(f"NULL AS {name}" for name, _, _ in table.columns[width:])
            view = f"CREATE TEMP VIEW {table.name} AS SELECT *, {added} FROM main.{table.name}"  # noqa: S608
            store.execute(view)


def earlier_column_count(table: Table, statement: str) -> int | None:
    """Number of columns if a statement makes the table of an earlier version; None: it is this version's, or not ours.

    Such a table has its key, and lacks some of the last columns.
    """
    if statement == table.statements()[0]:
        return None
    with_key = max(at for at, (name, _, _) in enumerate(table.columns) if name in table.key) + 1
    widths = range(with_key, len(table.columns))
    return next((n for n in widths if replace(table, columns=table.columns[:n]).statements()[0] == statement), None)
