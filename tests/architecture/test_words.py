"""Words of the glossary's column "not" do not occur in code, documents or texts of the page."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
KINDS = frozenset({".py", ".js", ".css", ".html", ".md"})
FOLDERS = ("app", "benchmarks", "docs", "sample_videos", "static", "tests", "tsr_engine")

ELSEWHERE = {
    "docs/glossary.md": "has the column",
    "tests/architecture/test_words.py": "has the exceptions",
    "tsr_engine/params/aliases.py": "has the old names of parameters",
    "tests/params/test_renamed_parameters.py": "tries the old names of parameters",
    "app/api/old_addresses.py": "has the old addresses",
    "tests/app/exchange/test_old_addresses.py": "tries the old addresses",
}
"""Files that need former names, and why."""
FORMER_FOLDERS = {
    "app/storage/migrations/versions/": "tables and columns keep their names",
    "docs/decisions/": "tells the history",
    "static/rerun/": "is the viewer of others",
}
STORED = re.compile(
    r"""
    __tablename__\ =\ "\w+"                               # tables keep their names
    | (?:home|root)\ /\ "(?:artefacts|glances)"           # so do folders of the data folder
    | `(?:artefacts|glances|uploads|thumbnails)/[^`]*`    # also where documents name them
    | "artefact":|\["artefact"\]|\.artefact\b             # what a model version learned from
    | "artefact",\ output\.id|kind\ ==\ "artefact"        # kinds of events are stored
    | case\ 'artefact'
    | "(?:likeness|outline)_\w*"|f"(?:likeness|outline)_\{|``(?:likeness|outline)_\*``|_likeness"|"cascade",\ "likeness"
    # arrays of models
    """,
    re.VERBOSE,
)
MARK = "former name"
"""A line with these words has an old name on purpose."""


def words() -> list[str]:
    """The words and phrases of the column."""
    rows = [line.split("|") for line in (ROOT / "docs/glossary.md").read_text(encoding="utf-8").splitlines()]
    cells = [row[3] for row in rows if len(row) == 5 and row[1].strip().startswith("**")]
    return sorted({word.strip().strip("`*") for cell in cells for word in cell.split(",") if word.strip()})


def texts() -> list[tuple[str, str]]:
    """Every file that a reader sees, by path, without data stored under a former name."""
    found = []
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            place = path.relative_to(ROOT).as_posix()
            known = place in ELSEWHERE or place.startswith(tuple(FORMER_FOLDERS))
            if path.suffix in KINDS and path.is_file() and not known:
                lines = path.read_text(encoding="utf-8").splitlines()
                found.append((place, "\n".join("" if MARK in line else STORED.sub("", line) for line in lines)))
    return found


def test_words_to_avoid_do_not_occur() -> None:
    # the plural of "ground truth" is a word
    wanted = re.compile(
        rf"(?<![A-Za-z])(?<!ground[ _-])(?:{'|'.join(map(re.escape, words()))})(?![A-Za-z])", re.IGNORECASE
    )
    found = [
        f"{place}:{number}: {hit.group()!r}"
        for place, text in texts()
        for number, line in enumerate(text.split("\n"), 1)
        for hit in wanted.finditer(line)
    ]
    assert not found, "see docs/glossary.md for the word to use:\n" + "\n".join(found)


def test_the_column_is_read() -> None:
    assert {"artefact", "likeness", "second look", "closer look"} <= set(words())
    assert len(words()) > 20


@pytest.mark.parametrize("place", sorted(ELSEWHERE))
def test_every_exception_is_needed(place: str) -> None:
    text = (ROOT / place).read_text(encoding="utf-8").lower()
    assert any(word.lower() in text for word in words()), f"{place} needs no exception"
