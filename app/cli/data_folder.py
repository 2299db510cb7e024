"""Opens a data folder, also while a server runs on it, and finds the things in it that people name."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.settings import DATABASE_FILE, Settings, load_settings, no_home
from app.storage.database import Database
from app.storage.identity import open_database
from app.storage.ids import RUN_ID
from app.storage.lookup import current_run_last
from app.storage.models import Run, TrackDocument, Video
from tsr_engine.errors import InputError
from tsr_engine.io.video_probe import video_sha256

_VIDEO = re.compile("[0-9a-f]{64}")


@contextmanager
def open_home(home: Path | None) -> Iterator[tuple[Settings, Database]]:
    """Open the database of a data folder; a server may run on it at the same time.

    Args:
        home: the folder; None: the default of ``tsr review``.

    Raises:
        InputError: there is no data folder.
    """
    settings = load_settings(home=home)
    if settings.database_url is None and not (settings.home / DATABASE_FILE).is_file():
        raise InputError(no_home(settings.home))
    database = open_database(settings)
    try:
        database.migrate(settings.home / "backups")
        yield settings, database
    finally:
        database.close()


def find_video(session: Session, name: str) -> Video:
    """Find a video of a data folder by its path, its file name or its 64 digits.

    Raises:
        InputError: there is none, or several have that name.
    """
    path = Path(name)
    digest = video_sha256(path) if path.is_file() else name
    if _VIDEO.fullmatch(digest):
        video = session.get(Video, digest)
        if video is None:
            raise InputError(f"{name} is not in the data folder. Add it in 'tsr review' first, or name another --home.")
        return video
    found = list(session.scalars(select(Video).where(Video.name == name)))
    if len(found) > 1:
        raise InputError(f"{len(found)} videos are called {name}. Name the file itself.")
    if not found:
        raise InputError(f"There is no run, evidence folder or video {name!r}. Check the name, or name another --home.")
    return found[0]


def find_run(session: Session, name: str) -> str:
    """Find a run by its id, or the newest complete run of a video (:func:`find_video`); imported runs come last.

    Raises:
        InputError: there is none.
    """
    if RUN_ID.fullmatch(name) and session.get(Run, name) is not None:
        return name
    video = find_video(session, name)
    query = select(Run.id).where(Run.video_id == video.id, Run.state == "complete", Run.kind != "whatif")
    runs = session.scalars(query.order_by(*current_run_last())).all()
    if not runs:
        raise InputError(f"{video.name} has no complete run. Start one in 'tsr review' and wait until it is complete.")
    return runs[-1]


def describe_run_choice(session: Session, run_id: str) -> str:
    """Say in one sentence which run a video's name means and, if that run has no corrections, which run has."""
    run = session.get_one(Run, run_id)
    others = session.scalars(select(Run).where(Run.video_id == run.video_id, Run.id != run_id)).all()
    documents = select(TrackDocument.run_id).where(TrackDocument.run_id.in_([run_id, *(one.id for one in others)]))
    corrected = set(session.scalars(documents.distinct()))
    name = session.get_one(Video, run.video_id).name
    text = f"{name} means {_display_name(run)}"
    better = [] if run_id in corrected else [one for one in others if one.id in corrected and one.state == "complete"]
    if not better:
        return f"{text}."
    newest = max(better, key=lambda one: one.order)
    return f"{text}, which has no corrections. There are some in {_display_name(newest)}: give its id to use it."


def _display_name(run: Run) -> str:
    name = f" {run.name!r}" if run.name else ""
    return f"the run{name} of {run.created:%Y-%m-%d %H:%M} UTC ({run.id})"
