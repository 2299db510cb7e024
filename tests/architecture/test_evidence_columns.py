"""Only ``tsr_engine.evidence`` queries an evidence store in SQL; everything else reads columns by name."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def sql_queries(source: str) -> list[int]:
    """Lines that call a method ``query``, which only evidence has: SQLAlchemy uses ``execute``."""
    if ".query" not in source:  # most modules need not be parsed
        return []
    return [
        node.lineno
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "query"
    ]


def test_no_sql_outside_the_evidence_package() -> None:
    inside = ROOT / "tsr_engine" / "evidence"
    found = [
        f"{path.relative_to(ROOT)}:{line}"
        for package in ("tsr_engine", "app", "benchmarks")
        for path in sorted((ROOT / package).rglob("*.py"))
        if inside not in path.parents
        for line in sql_queries(path.read_text(encoding="utf-8"))
    ]
    assert not found, "read columns with tsr_engine.evidence.columns.read_columns, or add a question there"


@pytest.mark.parametrize(("source", "lines"), [("x = reader.query('SELECT 1')\n", [1]), ("query('a')\nr.query\n", [])])
def test_a_query_is_found(source: str, lines: list[int]) -> None:
    assert sql_queries(source) == lines
