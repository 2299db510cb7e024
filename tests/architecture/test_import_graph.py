"""Nothing imports in a circle, and the picture of it is up to date."""

from __future__ import annotations

from pathlib import Path

from tests.architecture.import_graph import circle, modules, page, reduced, rooms

PAGE = Path(__file__).resolve().parents[2] / "docs" / "import-graph.md"


def test_no_modules_import_each_other_in_a_circle() -> None:
    assert circle(modules()) == []


def test_no_rooms_import_each_other_in_a_circle() -> None:
    assert circle(rooms()) == []


def test_the_page_is_up_to_date() -> None:
    command = "python -m tests.architecture.import_graph --out docs/import-graph.md"
    assert PAGE.read_text(encoding="utf-8") == page(), f"run {command}"


def test_a_circle_is_found() -> None:
    found = circle({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}})
    assert set(found) == {"a", "b", "c"}


def test_only_arrows_that_follow_from_others_are_left_out() -> None:
    graph = {"a": {"b", "c", "d"}, "b": {"c"}, "c": {"d"}, "d": set(), "e": {"a", "d"}, "f": {"d"}}
    assert reduced(graph) == {"a": {"b"}, "b": {"c"}, "c": {"d"}, "d": set(), "e": {"a"}, "f": {"d"}}
