"""Layers of the page: a folder of ``static/js`` imports only folders before it in ``LAYERS``.

Imports of types count too. Files directly below ``static/js`` are types, or assemble the page.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.architecture.import_graph import PAGE_SOURCES as PAGE
from tests.architecture.import_graph import circle, imported_by_page, page_modules

LAYERS = ("model", "modes", "store", "core", "api", "frames", "editing", "review", "operations", "behaviours", "views")
TYPES = ("dialog-types.js", "page-types.js", "state-types.js", "types.js")
SOURCES = sorted(PAGE.rglob("*.js"))


def layer_of(path: Path) -> str:
    """The folder below ``static/js``, or the file's name for files directly in it."""
    return path.relative_to(PAGE).parts[0]


def wrong_imports(path: Path, text: str) -> list[str]:
    """Imports from a later layer, or from a folder that is not in ``LAYERS``."""
    own = layer_of(path)
    if own not in LAYERS:
        return []
    allowed = {*LAYERS[: LAYERS.index(own) + 1], *TYPES}
    return [
        f"{own}/{path.name}: {layer_of(one)}" for one in imported_by_page(path, text) if layer_of(one) not in allowed
    ]


def test_a_module_imports_no_later_layer() -> None:
    assert [one for path in SOURCES for one in wrong_imports(path, path.read_text(encoding="utf-8"))] == []


def test_every_folder_is_a_layer() -> None:
    assert {layer_of(path) for path in SOURCES if path.parent != PAGE} == set(LAYERS)


def test_no_import_cycles() -> None:
    assert circle(page_modules()) == []


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("import { h } from '../views/dom.js';", ["store/x.js: views"]),
        ("/** @param {import('../views/view_actions.js').ViewApp} app */", ["store/x.js: views"]),
        ("export { h } from '../main.js';", ["store/x.js: main.js"]),
        ("import { a } from '../model/a.js'; /** @typedef {import('../types.js').Box} Box */", []),
    ],
)
def test_an_import_of_a_later_layer_is_found(text: str, found: list[str]) -> None:
    assert wrong_imports(PAGE / "store" / "x.js", text) == found
