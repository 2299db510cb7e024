"""Measures searches and overviews in a library of a million synthetic tracks."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from typing import TypeVar

import numpy as np
from pydantic_core import to_json
from sqlalchemy import func, insert, select, text
from sqlalchemy.orm import Session

from app.edits.documents import Segment, TrackDoc
from app.people.activity import ActivityService
from app.search.query import SearchAnswer, SearchRequest, answer
from app.storage.database import Database
from app.storage.migrations.versions.v0013_sums import fill as fill_sums
from app.storage.models import (
    Edit,
    Person,
    Run,
    SearchAttribute,
    SearchRun,
    SearchTrack,
    TrackDocument,
    Video,
    VideoTag,
)
from app.videos.view import video_listing
from tsr_engine.json_shapes import JsonObject

_Answer = TypeVar("_Answer")

MAX_MS = 300.0
"""Time limit of one answer, ms."""
TRACKS_OF_DRIVE = 100
_TIMES = 7
_PEOPLE = 20
_SET = "gtsrb-43"

QUESTIONS: dict[str, JsonObject] = {
    "everything, the most uncertain first": {},
    "every 60 below 70 % certain": {"label": ["60"], "uncertainty_min": 0.3},
    "the same, certain first": {"label": ["60"], "uncertainty_min": 0.3, "order": "asc"},
    "large and rejected": {"size_min": 180, "state": ["rejected"]},
    "large, by size": {"size_min": 100, "sort": "size"},
    "certain but undecided": {"uncertainty_max": 0.05, "state": ["open", "needs_work"]},
    "by one person on one day": {"author": ["p7"], "since": "2026-03-01", "until": "2026-03-01", "sort": "edited"},
    "words of notes": {"text": "bent pole"},
    "an attribute": {"attribute": ["dirty=yes"]},
    "a tag and a label": {"tag": ["night"], "label": ["stop"]},
    "a video by name": {"video": "drive 77"},
    "nothing passes": {"label": ["stop"], "size_min": 5000, "uncertainty_min": 0.99},
    "page 40 of everything": {"limit": 60, "_pages": 40},
}


def fill(database: Database, tracks: int, seed: int = 0) -> None:
    """Fill the tables of the search with synthetic tracks, and with edits of the last year to four in ten of them.

    Args:
        database: empty database with its tables.
        tracks: number of tracks.
        seed: random seed.
    """
    random = np.random.default_rng(seed)
    now = datetime.now(UTC)
    with database.write() as session:
        session.add_all(Person(id=f"{i:032x}", name=f"p{i}", key=f"p{i}", role="annotator") for i in range(_PEOPLE))
    for drive, start in enumerate(range(0, tracks, TRACKS_OF_DRIVE)):
        count = min(TRACKS_OF_DRIVE, tracks - start)
        video, run = f"{drive:064x}", f"{drive:032x}"
        rows = list(_rows(random, count, {"run_id": run, "video_id": video, "current": True, "set_key": _SET}))
        with database.write() as session:
            session.add(
                Video(id=video, name=f"drive {drive}.mp4", path=f"/{drive}", size=1, state="ready", warnings=[])
            )
            session.flush()
            session.add(Run(id=run, video_id=video, name="Run 1", state="complete", tracks=count, order=drive + 1))
            session.flush()
            session.add(SearchRun(run_id=run, video_id=video, basis="", set_key=_SET, seq=0, current=True))
            if drive % 20 == 0:
                session.add(VideoTag(video_id=video, tag="night"))
            session.execute(insert(SearchTrack), rows)
            _store_edits(session, rows, now - timedelta(days=365) * (1 - start / tracks))
            dirty = [
                {"run_id": run, "key": row["key"], "name": "dirty", "value": "yes" if i % 4 else "no"}
                for i, row in enumerate(rows)
                if i % 25 == 0
            ]
            session.execute(insert(SearchAttribute), dirty)
    with database.write() as session:
        fill_sums(session.connection())
    if database.is_sqlite:
        database.analyze()
    else:
        with database.write() as session:
            session.execute(text("ANALYZE"))


def _store_edits(session: Session, rows: list[JsonObject], moment: datetime) -> None:
    documents, edits = [], []
    for row in rows:
        if row["author"] is None:
            continue
        own = {"run_id": row["run_id"], "key": row["key"]}
        piece = Segment(track=int(row["key"][1:]), first=row["first"], last=row["last"])
        document = TrackDoc(key=row["key"], revision=1, segments=(piece,), review=row["state"]).model_dump(mode="json")
        documents.append(own | {"revision": 1, "document": document})
        moment += timedelta(seconds=20)
        edits.append(
            {
                "op_id": f"{row['run_id']}{row['key']}",
                "run_id": row["run_id"],
                "author": row["author"],
                "kind": "set_review",
                "command": {"name": "set_review", "key": row["key"], "review": row["state"]},
                "frame": row["frame"],
                "before": {row["key"]: None},
                "after": {row["key"]: document},
                "created": moment,
            }
        )
    if edits:
        session.execute(insert(TrackDocument), documents)
        session.execute(insert(Edit), edits)


def _rows(random: np.random.Generator, count: int, own: JsonObject) -> Iterator[JsonObject]:
    labels = random.integers(-1, 43, count).tolist()
    uncertainty = (random.beta(1.2, 3.0, count)).round(4).tolist()
    size = random.lognormal(3.6, 0.6, count).round(1).tolist()
    frames = random.integers(0, 100_000, count).tolist()
    judged = random.random(count).tolist()
    days = random.integers(1_767_225_600, 1_798_761_600, count).tolist()
    for i in range(count):
        edited = judged[i] < 0.4
        state = ("accepted", "accepted", "rejected", "needs_work")[i % 4] if edited else "open"
        yield own | {
            "key": f"m{i}",
            "label": labels[i],
            "state": state,
            "uncertainty": uncertainty[i],
            "engine_uncertainty": uncertainty[i],
            "size": size[i],
            "frame": frames[i],
            "x1": 100.0,
            "y1": 100.0,
            "x2": 100.0 + size[i],
            "y2": 100.0 + size[i],
            "first": frames[i],
            "last": frames[i] + 30,
            "revision": int(edited),
            "author": f"p{i % _PEOPLE}" if edited else None,
            "edited": days[i] if edited else 0,
            "notes": "leans on a bent pole" if i % 400 == 7 else "behind a tree" if i % 50 == 3 else "",
        }


def measured(database: Database) -> list[JsonObject]:
    """Median and largest time of each search, ms, and the number of tracks that it finds."""
    found = []
    for name, query in QUESTIONS.items():
        pages_to_turn = query.get("_pages", 1)
        request = SearchRequest.model_validate({key: value for key, value in query.items() if key != "_pages"})
        for _ in range(pages_to_turn - 1):
            with database.read() as session:
                following = answer(session, request, 0).next
            request = request.model_copy(update={"cursor": following or ""})

        def ask(request: SearchRequest = request) -> SearchAnswer:
            with database.read() as session:
                return answer(session, request, 0)

        times, result = _timed(ask)
        found.append({"question": name, **times, "total": result.total, "more": result.more})
    return found


def pages(database: Database) -> list[JsonObject]:
    """Median and largest time of the pages about people's work, ms."""
    activity = ActivityService(database)
    query: dict[str, Callable[[], object]] = {
        "overview": lambda: activity.overview(0),
        "activity of a person": lambda: activity.of("p7"),
        "list of videos": lambda: listed(database),
    }
    return [{"page": name, **_timed(ask)[0]} for name, ask in query.items()]


def listed(database: Database) -> bytes:
    """The uncompressed response of ``GET /api/videos``."""
    with database.read() as session:
        return to_json({"videos": video_listing(session)})


def _timed(ask: Callable[[], _Answer]) -> tuple[dict[str, float], _Answer]:
    """Median and largest of some times, ms, and the last answer."""
    times = []
    for _ in range(_TIMES):
        began = time.perf_counter()
        result = ask()
        times.append(1000 * (time.perf_counter() - began))
    return {"median_ms": round(statistics.median(times), 1), "slowest_ms": round(max(times), 1)}, result


def size_mb(database: Database) -> float:
    """Size of the whole database, MB."""
    with database.read() as session:
        if database.is_sqlite:
            size = session.scalar(text("SELECT page_count * page_size FROM pragma_page_count, pragma_page_size"))
        else:
            size = session.scalar(select(func.pg_database_size(func.current_database())))
    return round((size or 0) / 1e6, 1)
