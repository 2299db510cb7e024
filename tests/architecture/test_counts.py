"""Numbers that may only go down."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LATE_IMPORTS = 28
"""Imports within functions outside the command line: of an extra, or of something large that few processes need."""


def parsed(*folders: str) -> Iterator[tuple[str, ast.Module]]:
    """Every Python module below folders, with its path."""
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*.py")):
            yield path.relative_to(ROOT).as_posix(), ast.parse(path.read_text(encoding="utf-8"))


def late_imports(tree: ast.Module) -> list[int]:
    """Lines of imports within functions."""
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    lines = {
        inner.lineno for node in functions for inner in ast.walk(node) if isinstance(inner, ast.Import | ast.ImportFrom)
    }
    return sorted(lines)


def test_few_imports_are_inside_functions() -> None:
    found = [
        f"{name}:{line}"
        for name, tree in parsed("app", "tsr_engine", "sample_videos")
        if "/cli/" not in name
        for line in late_imports(tree)
    ]
    assert len(found) <= LATE_IMPORTS, found
