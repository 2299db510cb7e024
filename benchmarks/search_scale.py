"""A library of a million tracks that are made up, and how long questions to its search take."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from sqlalchemy import func, insert, select, text

from app.search.query import SearchRequest, answer
from app.storage.database import Database
from app.storage.models import Run, SearchAttribute, SearchRun, SearchTrack, Video, VideoTag

__all__ = ["MOST_MS", "QUESTIONS", "fill", "measured", "size_mb"]

MOST_MS = 300.0
"""The budget of one answer."""
_TRACKS = 500
"""Of a drive."""
_TIMES = 7
_SET = "gtsrb-43"

QUESTIONS: dict[str, dict[str, Any]] = {
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
    """Put made-up tracks into the tables of the search.

    Args:
        database: fresh, with its tables.
        tracks: how many.
        seed: of everything random.
    """
    random = np.random.default_rng(seed)
    for drive, start in enumerate(range(0, tracks, _TRACKS)):
        count = min(_TRACKS, tracks - start)
        video, run = f"{drive:064x}", f"{drive:032x}"
        rows = list(_rows(random, count, {"run_id": run, "video_id": video, "current": True, "set_key": _SET}))
        with database.write() as session:
            session.add(
                Video(id=video, name=f"drive {drive}.mp4", path=f"/{drive}", size=1, state="ready", warnings=[])
            )
            session.flush()
            session.add(Run(id=run, video_id=video, name="Run 1", state="complete", order=drive + 1))
            session.flush()
            session.add(SearchRun(run_id=run, video_id=video, basis="", set_key=_SET, seq=0, current=True))
            if drive % 20 == 0:
                session.add(VideoTag(video_id=video, tag="night"))
            session.execute(insert(SearchTrack), rows)
            dirty = [
                {"run_id": run, "key": row["key"], "name": "dirty", "value": "yes" if i % 4 else "no"}
                for i, row in enumerate(rows)
                if i % 25 == 0
            ]
            session.execute(insert(SearchAttribute), dirty)
    with database.engine.connect() as connection:
        connection.execute(text("ANALYZE"))
        connection.commit()


def _rows(random: np.random.Generator, count: int, own: dict[str, Any]) -> Iterator[dict[str, Any]]:
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
            "author": f"p{i % 20}" if edited else None,
            "edited": days[i] if edited else 0,
            "notes": "leans on a bent pole" if i % 400 == 7 else "behind a tree" if i % 50 == 3 else "",
        }


def measured(database: Database) -> list[dict[str, Any]]:
    """Time of each question: median and slowest of some, ms, and how many tracks it counts."""
    found = []
    for name, asked in QUESTIONS.items():
        pages = asked.get("_pages", 1)
        request = SearchRequest.model_validate({key: value for key, value in asked.items() if key != "_pages"})
        for _ in range(pages - 1):
            with database.read() as session:
                following = answer(session, request, 0).next
            request = request.model_copy(update={"cursor": following or ""})
        times = []
        for _ in range(_TIMES):
            began = time.perf_counter()
            with database.read() as session:
                result = answer(session, request, 0)
            times.append(1000 * (time.perf_counter() - began))
        found.append(
            {
                "question": name,
                "median_ms": round(statistics.median(times), 1),
                "slowest_ms": round(max(times), 1),
                "total": result.total,
                "more": result.more,
            }
        )
    return found


def size_mb(database: Database) -> float:
    """Size of the whole database, MB."""
    with database.read() as session:
        if database.is_sqlite:
            pages = session.scalar(text("SELECT page_count * page_size FROM pragma_page_count, pragma_page_size"))
        else:
            pages = session.scalar(select(func.pg_database_size(func.current_database())))
    return round((pages or 0) / 1e6, 1)
