"""The page's types match the server's answers."""

from __future__ import annotations

import pytest

from tests.architecture.page_types import FILE, ROOT, TOOL, page_types, shapes


@pytest.mark.skipif(not TOOL.is_file(), reason="openapi-typescript is not installed: make test installs it")
def test_the_types_are_up_to_date() -> None:
    written = (ROOT / FILE).read_text(encoding="utf-8")
    assert written == page_types(), "an answer of the server changed: run python -m tests.architecture.page_types"


def test_aliases_name_existing_types() -> None:
    names = (ROOT / "static" / "js" / "types.js").read_text(encoding="utf-8").split("Schemas['")[1:]
    known = shapes()["components"]["schemas"]  # type: ignore[index]
    assert len(names) > 30
    assert [name for name in (text.partition("'")[0] for text in names) if name not in known] == []
