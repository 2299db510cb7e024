"""Runs as people name them on the command line: by run, by evidence folder, by video."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.errors import ApiError, Invalid, StorageFull
from app.exchange.dataset import Source, evidence_source, home_source
from app.settings import Settings, load_settings
from app.storage.database import Database
from app.storage.models import Run, Video
from tsr_engine.errors import InputError, StorageError, TsrError, UsageError
from tsr_engine.evidence.schema import RUN_FILE
from tsr_engine.io.video_probe import video_sha256

__all__ = ["as_command_error", "named_sources", "named_video", "open_home"]

_RUN = re.compile("[0-9a-f]{32}")
_VIDEO = re.compile("[0-9a-f]{64}")
_FILE = "tsr.sqlite"


@contextmanager
def open_home(home: Path | None) -> Iterator[tuple[Settings, Database]]:
    """The database of a data folder, beside a server that may run on it.

    Args:
        home: the folder; None: as ``tsr review`` would choose.

    Raises:
        InputError: there is no data folder.
    """
    settings = load_settings(home=home)
    if settings.database_url is None and not (settings.home / _FILE).is_file():
        raise InputError(
            f"There is no data folder at {settings.home}. Name one with --home, or start 'tsr review' once."
        )
    database = Database(settings.database)
    try:
        database.migrate(settings.home / "backups")
        yield settings, database
    finally:
        database.close()


@contextmanager
def as_command_error() -> Iterator[None]:
    """Failures of the server's parts as those of the command line, with their exit codes."""
    try:
        yield
    except ApiError as error:
        raise _command_error(error) from None


def _command_error(error: ApiError) -> TsrError:
    if isinstance(error, Invalid):
        return UsageError(error.message)
    return StorageError(error.message) if isinstance(error, StorageFull) else InputError(error.message)


def named_sources(names: Sequence[str], home: Path | None, video: Path | None) -> list[Source]:
    """The runs behind names.

    Args:
        names: a run's 32 digits, an evidence folder, a video's file, or its 64 digits; for a video its newest complete
            run.
        home: data folder of runs and videos.
        video: the file of a bare evidence folder.

    Raises:
        InputError: there is no such run, or it cannot be exported.
        UsageError: ``video`` with something else than one bare evidence folder.
    """
    bare = [name for name in names if _bare(Path(name)) is not None]
    if video is not None and (len(names) != 1 or not bare):
        raise UsageError("--video names the file of one evidence folder. Leave it out for runs of a data folder.")
    sources: list[Source] = []
    for name in names:
        folder = _bare(Path(name))
        with as_command_error():
            if folder is not None:
                sources.append(evidence_source(folder, video))
                continue
            inside = _inside(Path(name))
            with open_home(home if inside is None else inside) as (settings, database), database.read() as session:
                run_id = Path(name).resolve().name if inside is not None else _run_named(session, name)
                sources.append(home_source(session, settings.home, run_id))
    return sources


def named_video(session: Session, name: str) -> Video:
    """A video of a data folder by its file, its file's name or its 64 digits.

    Raises:
        InputError: there is none, or there are several of that name.
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


def _run_named(session: Session, name: str) -> str:
    if _RUN.fullmatch(name) and session.get(Run, name) is not None:
        return name
    video = named_video(session, name)
    query = select(Run.id).where(Run.video_id == video.id, Run.state == "complete", Run.kind != "whatif")
    newest = session.scalars(query.order_by(Run.created.desc()).limit(1)).first()
    if newest is None:
        raise InputError(f"{video.name} has no complete run. Start one in 'tsr review', and wait for its end.")
    return newest


def _bare(path: Path) -> Path | None:
    """An evidence folder that belongs to no data folder."""
    return path if (path / RUN_FILE).is_file() and _inside(path) is None else None


def _inside(path: Path) -> Path | None:
    """The data folder that an evidence folder lies in: corrections are there, not in the folder itself."""
    folder = path.resolve()
    if not (folder / RUN_FILE).is_file() or not _RUN.fullmatch(folder.name) or folder.parent.name != "runs":
        return None
    home = folder.parent.parent
    return home if (home / _FILE).is_file() else None
