"""The layers in pyproject.toml, and rules for all modules."""

from __future__ import annotations

import ast
import importlib
import io
import re
import subprocess
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("tsr_engine", "app", "sample_videos")
NUMERIC = ("channels", "detection", "gating", "geometry", "online", "recognition", "tracking")
SOURCES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
MAX_ANY = 45
"""Lines of code with ``Any``."""
MUTABLE_CALLS = {"list", "dict", "set", "deque", "defaultdict", "Counter", "OrderedDict", "count", "bytearray"}


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def public_definitions(tree: ast.Module) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef]:
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            yield node
            if isinstance(node, ast.ClassDef):
                for inner in node.body:
                    # Learned state (a trailing underscore) is described by its class.
                    if isinstance(inner, ast.FunctionDef) and not (
                        inner.name.startswith("_") or inner.name.endswith("_")
                    ):
                        yield inner


def is_mutable(value: ast.expr | None) -> bool:
    if isinstance(value, ast.List | ast.Dict | ast.Set | ast.ListComp | ast.DictComp | ast.SetComp):
        return True
    if isinstance(value, ast.Call):
        called = value.func
        return (called.id if isinstance(called, ast.Name) else getattr(called, "attr", "")) in MUTABLE_CALLS
    return False


def test_import_linter_contracts_hold() -> None:
    tool = Path(sys.executable).with_name("lint-imports")
    if not tool.exists():
        pytest.fail(f"{tool} is missing: install the dev extra")
    done = subprocess.run([tool, "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def trees() -> dict[Path, ast.Module]:
    return {path: ast.parse(path.read_text(encoding="utf-8")) for path in SOURCES}


def test_public_definitions_have_docstrings(trees: dict[Path, ast.Module]) -> None:
    silent = [name_of(path) for path, tree in trees.items() if not ast.get_docstring(tree)]
    for path, tree in trees.items():
        silent += [f"{name_of(path)}: {n.name}" for n in public_definitions(tree) if not ast.get_docstring(n)]
    assert silent == []


def test_any_stays_rare() -> None:
    """``Any`` turns mypy off; it is for untyped libraries and for values of JSON and SQLite rows."""
    found = {
        f"{name_of(path)}:{line}": explained
        for path in (*SOURCES, *(ROOT / "benchmarks").rglob("*.py"))
        for line, explained in lines_with_any(path.read_text(encoding="utf-8")).items()
    }
    bare = [place for place, explained in found.items() if not explained]
    assert not bare, f"Give each a type, or say on its line or the line above why not, `# Any: reason`: {bare}"
    assert len(found) <= MAX_ANY, f"{len(found)} lines with Any, more than {MAX_ANY}. Give a type to one of {[*found]}"


def lines_with_any(source: str) -> dict[int, bool]:
    """Lines of code with ``Any``, imports aside -> whether a comment on the line, or one above it, gives the reason."""
    if "Any" not in source:
        return {}
    tree, tokens = ast.parse(source), list(tokenize.generate_tokens(io.StringIO(source).readline))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]
    imported = {line for node in imports for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)}
    reasons = [one for one in tokens if one.type == tokenize.COMMENT and re.search(r"# Any: \w", one.string)]
    explained = {one.start[0] + one.line.lstrip().startswith("#") for one in reasons}
    lines = {one.start[0] for one in tokens if one.type == tokenize.NAME and one.string == "Any"}
    return {line: line in explained for line in sorted(lines - imported)}


def test_dunder_all_names_exist(trees: dict[Path, ast.Module]) -> None:
    wrong = []
    for path, tree in trees.items():
        exported, defined = names_of(path, tree)
        twice = len(exported) - len(set(exported))
        if twice or not set(exported) <= defined:
            wrong.append(f"{name_of(path)}: {twice} twice, not there: {sorted(set(exported) - defined)}")
    assert wrong == []


def names_of(path: Path, tree: ast.Module) -> tuple[list[str], set[str]]:
    """Names in a module's ``__all__``, and names that the module defines."""
    exported: list[str] = []
    defined: set[str] = set()
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            defined.add(node.name)
        elif isinstance(node, ast.ImportFrom | ast.Import):
            defined |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, ast.Assign):
            for target in node.targets:
                if isinstance(target, ast.Name):
                    defined.add(target.id)
                    if target.id == "__all__":
                        exported = ast.literal_eval(node.value)
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            defined.add(node.target.id)
    if "__getattr__" in defined:  # names that are imported on first access
        module = importlib.import_module(
            ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        )
        defined |= {name for name in exported if hasattr(module, name)}
    return exported, defined


def test_numeric_modules_hold_no_state(trees: dict[Path, ast.Module]) -> None:
    held = []
    for path, tree in trees.items():
        if path.relative_to(ROOT).parts[1] in NUMERIC:
            held += [f"{name_of(path)}: {name}" for name in state_of(tree)]
    assert held == []


def state_of(tree: ast.Module) -> list[str]:
    """Module-level names that can change while the program runs."""
    held = []
    for node in tree.body:
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        names = [t.id for t in targets if isinstance(t, ast.Name) and t.id != "__all__"]
        # A constant table is spelt in capitals and never written to; any other mutable value is state.
        if names and is_mutable(node.value) and not all(n.strip("_").isupper() for n in names):  # type: ignore[union-attr]
            held += names
    return held + [name for node in ast.walk(tree) if isinstance(node, ast.Global) for name in node.names]


def test_each_check_finds_a_violation() -> None:
    tree = ast.parse("__all__ = ['gone', 'gone']\nseen = []\nTABLE = {}\ndef told(): ...\n")
    exported, defined = names_of(ROOT / "app" / "none.py", tree)
    assert exported == ["gone", "gone"]
    assert defined == {"__all__", "seen", "TABLE", "told"}
    assert state_of(tree) == ["seen"]
    assert [one.name for one in public_definitions(tree)] == ["told"]
    lines = ("from typing import (", "    Any,", ")", "'Any text'", "a: Any = 'Any'  # Any: told", "b: Any")
    source = "\n".join([*lines, "# Any: told", "c: Any", "d: Any  # Any", ""])
    assert lines_with_any(source) == {5: True, 6: False, 8: True, 9: False}


@pytest.mark.parametrize("path", sorted((ROOT / "app" / "api").glob("*.py")), ids=name_of)
def test_routes_leave_writing_to_services(path: Path) -> None:
    lines = path.read_text(encoding="utf-8").splitlines()
    assert not [line for line in lines if "database.write(" in line]
