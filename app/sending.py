"""Copies finished files to the shared files, and keeps the data folder within its size limit.

A row says where its files are: on this server until all of them are in the shared files, then there. So no reader sees
incomplete files, and a restarted server continues with the rows that still name it.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeAlias, cast

from sqlalchemy import select
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from app.events import EventBus
from app.files.shared import UNUSED, Kept, SharedFiles
from app.files.store import FilesAwayError
from app.log_once import LogOnce
from app.outputs.folders import output_folder
from app.outputs.view import publish_output
from app.runs.view import publish_run
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import ModelVersion, Output, Run, Video
from app.training.view import publish_model
from app.videos.opened import library_file
from app.videos.thumbnails import import_files
from app.videos.view import publish_video
from tsr_engine.errors import VideoError

__all__ = ["AGAIN", "Sending"]

AGAIN: Final = 60.0
"""Seconds until a failed copy is tried again."""
_TIDY: Final = 60.0
"""Seconds between checks of the size of the data folder."""
_AT_ONCE: Final = 500
_log = logging.getLogger("tsr.server")

_Row: TypeAlias = Video | Run | Output | ModelVersion
_STATES: Final[dict[type[_Row], str]] = {ModelVersion: "complete", Video: "ready", Run: "complete", Output: "complete"}
_ROWS_OF: Final[dict[str, type[_Row]]] = {
    "models": ModelVersion,
    "runs": Run,
    output_folder(Path(), "-").parent.name: Output,
}
"""Top folder of a name in the shared files -> class of its rows; all other names belong to videos."""


class _Left(Exception):
    """The server ends."""


@dataclass(frozen=True, slots=True)
class _Thing:
    name: str
    path: Path
    own: bool
    """Whether it lies in the data folder, so that removing it makes room there."""


class Sending:
    """Copies finished files to the shared files; thread-safe, one per server.

    Args:
        settings: with the data folder and its size limit.
        database: its rows say which files are finished.
        events: notifies pages and the search.
        files: the shared files.

    Attributes:
        cache_mb: limit of fetched files in the data folder, MiB.
    """

    def __init__(self, settings: Settings, database: Database, events: EventBus, files: SharedFiles) -> None:
        self._settings = settings
        self.cache_mb = settings.files_cache_mb
        self._database = database
        self._events = events
        self._files = files
        self._later: dict[str, float] = {}
        self._trouble: str | None = None
        self._tidied = 0.0
        self._leaving = False
        self._log_once = LogOnce(_log, "Finished files cannot be shared")

    @property
    def trouble(self) -> str | None:
        """A sentence while files cannot be copied; None: no problem."""
        return self._trouble

    def leave(self) -> None:
        """Stop; the next server repeats an unfinished copy."""
        self._leaving = True

    def tick(self) -> None:
        """Copy finished files, then make room; failures are logged."""
        try:
            self.send()
            if time.monotonic() - self._tidied > _TIDY:
                self._tidied = time.monotonic()
                self.tidy()
        except _Left:
            return
        except (SQLAlchemyError, OSError, FilesAwayError) as error:
            self._log_once.failed(error)

    def send(self) -> None:
        """Copy all finished files that lie only on this server."""
        now = time.monotonic()
        self._later = {key: until for key, until in self._later.items() if until > now}
        if not self._later:
            self._trouble = None
            self._log_once.recovered()
        for table, state in _STATES.items():
            with self._database.read() as session:
                query = select(table.id).where(table.place == self._database.here, table.state == state)
                waiting = session.scalars(query).all()
            for key in waiting:
                if key not in self._later and not self._try(table, key):
                    return

    def tidy(self) -> None:
        """Delete local files without a row, and above the limit also the shared ones that were not used for longest."""
        kept = self._files.kept()
        gone = self._gone(kept)
        for one in gone:
            self._files.drop(one)
        left = [one for one in kept if one not in gone]
        over = sum(one.size for one in left) - self.cache_mb * 2**20
        for one in left:
            if over <= 0 or time.time() - one.used < UNUSED:
                return
            try:
                there = self._files.store.holds(one.name)  # the shared copy is about to be the only one
            except FilesAwayError as error:
                self._log_once.failed(error)
                continue
            if there:
                self._files.drop(one)
                over -= one.size

    # ------------------------------------------------------------------------------------------------------ inside

    def _try(self, table: type[_Row], key: str) -> bool:
        """Copy the files of a row, or postpone it; False: the other rows should wait too."""
        try:
            with self._database.read() as session:
                row = cast(_Row | None, session.get(table, key))
            if row is not None:
                self._send(table, row)
        except FilesAwayError as error:
            self._later[key] = time.monotonic() + AGAIN
            self._trouble = f"{error} Finished files stay on this server until then."
            self._log_once.failed(error)
            return False
        except (OSError, VideoError) as error:  # the local files are damaged
            self._later[key] = time.monotonic() + AGAIN
            self._log_once.failed(error)
        return True

    def _send(self, table: type[_Row], row: _Row) -> None:
        things = list(self._things(row))
        sizes = {}
        for thing in things:
            listed = self._files.store.put(thing.name, thing.path, self._wait)
            sizes[thing.name] = sum(size for size, _ in listed.values())
            if isinstance(row, Video) and thing.name == f"videos/{row.id}" and listed[""][1] != row.id:
                self._files.store.remove(thing.name)
                raise VideoError(f"{thing.path} has changed since it was added: it cannot be shared. Put it back.")
        with self._database.write() as session:
            found = cast(_Row | None, session.get(table, row.id, with_for_update=True))
            sent = found is not None and found.place == self._database.here and found.state == _STATES[table]
            if sent:
                assert found is not None
                found.place = self._database.shared
                _publish(session, self._events, found)
        if not sent:
            self._files.forget(*(thing.name for thing in things))  # the row was removed meanwhile
            return
        for thing in things:
            if thing.own:
                self._files.note(thing.name, thing.path, sizes[thing.name])

    def _things(self, row: _Row) -> Iterator[_Thing]:
        home = self._settings.home
        if isinstance(row, Video):
            file = library_file(self._settings, row)
            file.open().close()  # check that the file still has the video's bytes
            yield _Thing(f"videos/{row.id}", file.path, file.path.is_relative_to(home))
            for path in import_files(home, row.id):
                if path.is_file():
                    yield _Thing(str(path.relative_to(home)), path, True)
            return
        name = str(Path(row.path).parent) if isinstance(row, Output) else row.folder
        yield _Thing(name, home / name, True)

    def _wait(self) -> None:
        if self._leaving:
            raise _Left

    def _gone(self, kept: list[Kept]) -> list[Kept]:
        """The kept files that no row names any more."""
        found: list[Kept] = []
        for start in range(0, len(kept), _AT_ONCE):
            part = kept[start:][:_AT_ONCE]
            with self._database.read() as session:
                for table in _STATES:
                    ours = [one for one in part if _ROWS_OF.get(one.name.partition("/")[0], Video) is table]
                    there = set(session.scalars(select(table.id).where(table.id.in_({_id(one) for one in ours}))))
                    found += [one for one in ours if _id(one) not in there]
        return found


def _id(kept: Kept) -> str:
    return Path(kept.name).stem


def _publish(session: Session, events: EventBus, row: _Row) -> None:
    if isinstance(row, Video):
        publish_video(session, events, row)
    elif isinstance(row, Run):
        publish_run(session, events, row)
    elif isinstance(row, Output):
        publish_output(session, events, row)
    else:
        publish_model(session, events, row)
