"""Two runs with the same evidence, bit by bit."""

from __future__ import annotations

from itertools import zip_longest
from pathlib import Path

from tsr_engine.evidence import EvidenceReader
from tsr_engine.evidence.compare import differences


def assert_same_evidence(one: Path, other: Path) -> None:
    """Fail with the first differences; timings are ignored."""
    with EvidenceReader(one) as a, EvidenceReader(other) as b:
        assert (a.state, b.state) == ("complete", "complete"), (a.state, b.state)
        assert list(a.result_rows()) == list(b.result_rows())
        for x, y in zip_longest(a.frames(), b.frames()):
            found = list(differences(x, y, ignore=frozenset({"timings"})))
            assert not found, found[:5]
