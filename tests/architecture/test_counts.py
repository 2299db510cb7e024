"""Counts that may only decrease."""

from __future__ import annotations

import ast
import re
import statistics
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LATE_IMPORTS = 32
"""Imports within functions outside the command line: of an extra, or of something large that few processes need."""
LONGEST = 350
"""Lines of the longest module."""
MEDIAN = 120
"""Median lines of a module."""
PRIVATE = 53
"""Uses of private names by tests; names of other libraries count too."""
MAYBE_PRIVATE = r"""(?m)(?<!self)(?<!cls)\._[A-Za-z]|["']_[A-Za-z]|import .*\b_[A-Za-z]|^[ \t]+_\w+( as \w+)?,$"""
"""A text without a match has no private use; most modules of tests have none, and need not be parsed."""
PATCHES = {"delattr", "getattr", "object", "patch", "setattr"}


def parsed(*folders: str, having: str = "") -> Iterator[tuple[str, ast.Module]]:
    """Path and syntax tree of every Python module in the folders that match."""
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*.py")):
            text = path.read_text(encoding="utf-8")
            if re.search(having, text):
                yield path.relative_to(ROOT).as_posix(), ast.parse(text)


def late_imports(tree: ast.Module) -> list[int]:
    """Line numbers of imports within functions."""
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    lines = {
        inner.lineno for node in functions for inner in ast.walk(node) if isinstance(inner, ast.Import | ast.ImportFrom)
    }
    return sorted(lines)


def test_modules_are_short() -> None:
    paths = [path for place in ("app", "tsr_engine", "sample_videos") for path in (ROOT / place).rglob("*.py")]
    paths += [path for path in (ROOT / "static" / "js").rglob("*.js") if "vendor" not in path.parts]
    lengths = {path.relative_to(ROOT).as_posix(): len(path.read_bytes().splitlines()) for path in paths}
    assert [name for name, count in lengths.items() if count > LONGEST] == []
    assert statistics.median(lengths.values()) <= MEDIAN


def test_few_imports_are_inside_functions() -> None:
    found = [
        f"{name}:{line}"
        for name, tree in parsed("app", "tsr_engine", "sample_videos", having=r"(?m)^[ \t]+(from|import) ")
        if "/cli/" not in name
        for line in late_imports(tree)
    ]
    assert len(found) <= LATE_IMPORTS, "\n".join(found)


def is_private(name: str) -> bool:
    """Whether a name has exactly one leading underscore."""
    return name.startswith("_") and not name.startswith("__")


def private_uses(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Line and name of each private name of another module or object that is read, imported or replaced."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and is_private(node.attr):
            if not (isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")):
                yield node.lineno, node.attr
        elif isinstance(node, ast.ImportFrom):
            yield from ((node.lineno, alias.name) for alias in node.names if is_private(alias.name))
        elif isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] in PATCHES:
            for given in node.args:
                if isinstance(given, ast.Constant) and is_private(str(given.value).rpartition(".")[2]):
                    yield node.lineno, str(given.value)


def test_tests_use_few_private_names() -> None:
    found = [
        f"{path}:{line} {name}"
        for path, tree in parsed("tests", having=MAYBE_PRIVATE)
        for line, name in private_uses(tree)
    ]
    assert len(found) <= PRIVATE, "\n".join(found)


def test_counters_on_an_example() -> None:
    text = "from a import _b\nx._c\nself._d\npatch.setattr(x, '_e', 1)\npatch.setattr('x.y._f', 1)\nx.__g__\n"
    assert sorted(name for _, name in private_uses(ast.parse(text))) == ["_b", "_c", "_e", "x.y._f"]
    assert late_imports(ast.parse("import a\ndef f():\n    import b\n    def g():\n        from c import d\n")) == [
        3,
        5,
    ]
