"""There are no import cycles, and the diagram of imports is up to date."""

from __future__ import annotations

from pathlib import Path

from tests.architecture.import_graph import circle, modules, package_graph, page, transitive_reduction

PAGE = Path(__file__).resolve().parents[2] / "docs" / "import-graph.md"


def test_no_import_cycles_of_modules() -> None:
    assert circle(modules()) == []


def test_no_import_cycles_of_packages() -> None:
    assert circle(package_graph()) == []


def test_the_page_is_up_to_date() -> None:
    command = "python -m tests.architecture.import_graph --out docs/import-graph.md"
    assert PAGE.read_text(encoding="utf-8") == page(), f"run {command}"


def test_a_cycle_is_found() -> None:
    found = circle({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}})
    assert set(found) == {"a", "b", "c"}


def test_only_implied_arrows_are_left_out() -> None:
    graph = {"a": {"b", "c", "d"}, "b": {"c"}, "c": {"d"}, "d": set(), "e": {"a", "d"}, "f": {"d"}}
    assert transitive_reduction(graph) == {"a": {"b"}, "b": {"c"}, "c": {"d"}, "d": set(), "e": {"a"}, "f": {"d"}}
