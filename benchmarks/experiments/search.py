"""Measures the time of searches over a million tracks, on both databases."""

from __future__ import annotations

import os
import time
from pathlib import Path

from app.storage.database import Database
from benchmarks.experiment import Data, Experiment, Result
from benchmarks.reporting.markdown import table
from benchmarks.timing.search import MAX_MS, TRACKS_OF_DRIVE, fill, measured, pages, size_mb
from tsr_engine.json_shapes import JsonObject

TRACKS = 1_000_000
POSTGRES = "TSR_BENCH_POSTGRES"
"""Environment variable with the address of an empty PostgreSQL database."""


def _run(data: Data) -> Result:
    tracks = int(os.environ.get("TSR_BENCH_TRACKS", TRACKS))
    file = data.scratch / "search.sqlite"
    for old in (file, Path(f"{file}-wal"), Path(f"{file}-shm")):
        old.unlink(missing_ok=True)
    figures = {"SQLite": _on(f"sqlite:///{file}", tracks, data.seed)}
    if POSTGRES in os.environ:
        figures["PostgreSQL"] = _on(os.environ[POSTGRES], tracks, data.seed)
    file.unlink(missing_ok=True)
    return Result(
        data=f"{tracks:,} tracks in {-(-tracks // TRACKS_OF_DRIVE):,} synthetic drives: 44 labels, 20 people, notes on "
        "2 % of the tracks, an attribute on 4 %, an edit and a document on 40 %. Each answer is a page of 60 with its "
        "count; each question is asked seven times.",
        figures={"tracks": tracks, "databases": figures},
        settings={"seed": data.seed},
    )


def _on(url: str, tracks: int, seed: int) -> JsonObject:
    database = Database(url)
    try:
        database.migrate()
        began = time.monotonic()
        fill(database, tracks, seed)
        filled = time.monotonic() - began
        return {
            "mb": size_mb(database),
            "fill_seconds": round(filled, 1),
            "questions": measured(database),
            "pages": pages(database),
        }
    finally:
        database.close()


def _report(result: Result) -> str:
    databases: JsonObject = result.figures["databases"]
    rows = [["question", "found", *(f"{name}, median / slowest" for name in databases)]]
    first = next(iter(databases.values()))
    over = []
    for i, one in enumerate(first["questions"]):
        answers = [each["questions"][i] for each in databases.values()]
        more = " or more" if one["more"] else ""
        rows.append([one["question"], f"{one['total']:,}{more}", *map(_times, answers)])
        over += [one["question"] for each in answers if each["median_ms"] > MAX_MS]
    for i, one in enumerate(first["pages"]):
        rows.append([f"the page: {one['page']}", "", *(_times(each["pages"][i]) for each in databases.values())])
    sizes = ", ".join(
        f"{name} {each['mb']:,.0f} MB, filled in {each['fill_seconds']:,.0f} s" for name, each in databases.items()
    )
    verdict = f"exceeded by {'; '.join(dict.fromkeys(over))}" if over else "met by every question"
    return f"{table(rows)}\nBar of a question: a median of {MAX_MS:g} ms, {verdict}. Size of the database: {sizes}.\n"


def _times(answer: JsonObject) -> str:
    return f"{answer['median_ms']:.0f} / {answer['slowest_ms']:.0f} ms"


EXPERIMENT = Experiment(
    "search", "Search across videos", "How long does a search take in a library of a million tracks?", _run, _report
)
