"""Tests replace the clock of one module, never that of ``time``, which servers in the same process use."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
SHARED_CLOCK = re.compile(
    r"""setattr\(\s*(?:time\s*,|"[\w.]*\btime(?:\.\w+)?"\s*,\s*"?(?:monotonic|time|sleep)|"(?:[\w.]*\.)?time\.\w+")"""
)


def test_no_test_replaces_the_clock_of_the_process() -> None:
    found = [
        f"{path.relative_to(TESTS)}: {match[0]}"
        for path in sorted(TESTS.rglob("*.py"))
        if path != Path(__file__)
        for match in SHARED_CLOCK.finditer(path.read_text(encoding="utf-8"))
    ]
    assert not found, "an event loop that looks at such a clock sleeps for hours; replace the module's name `time`"


@pytest.mark.parametrize(
    ("text", "shared"),
    [
        ('monkeypatch.setattr("app.storage.servers.time.monotonic", fake)', True),
        ('monkeypatch.setattr(time, "monotonic", fake)', True),
        ('monkeypatch.setattr(places, "time", SimpleNamespace(monotonic=fake))', False),
    ],
)
def test_a_replaced_clock_is_found(text: str, shared: bool) -> None:
    assert bool(SHARED_CLOCK.search(text)) is shared
