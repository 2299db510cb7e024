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
from app.files.shared import MIN_UNUSED_S, LocalCopy, SharedFiles
from app.files.store import SharedFilesError
from app.log_once import LogOnce
from app.outputs.folders import output_folder
from app.outputs.view import publish_output
from app.runs.view import publish_run
from app.settings import Settings
from app.storage.database import Database
from app.storage.lookup import in_parts
from app.storage.models import ModelVersion, Output, Run, Video
from app.training.view import publish_model
from app.videos.checked_file import library_file
from app.videos.import_files import import_files
from app.videos.view import publish_video
from tsr_engine.errors import VideoError

RETRY_DELAY_S: Final = 60.0
"""Seconds until a failed copy is tried again."""
PROBE_INTERVAL_S: Final = 2.0
"""Seconds between checks whether the shared files answer while a copy takes long."""
_EVICTION_INTERVAL_S: Final = 60.0
"""Seconds between checks of the size of the data folder."""
_STAYS: Final = "Finished files stay on this server until then."
_log = logging.getLogger("tsr.server")

_Row: TypeAlias = Video | Run | Output | ModelVersion
_STATES: Final[dict[type[_Row], str]] = {ModelVersion: "complete", Video: "ready", Run: "complete", Output: "complete"}
_ROWS_OF: Final[dict[str, type[_Row]]] = {
    "models": ModelVersion,
    "runs": Run,
    output_folder(Path(), "-").parent.name: Output,
}
"""Top folder of a name in the shared files -> class of its rows; all other names belong to videos."""


class _Stopping(Exception):
    """The server ends."""


@dataclass(frozen=True, slots=True)
class _Entry:
    name: str
    path: Path
    is_in_home: bool
    """Whether it lies in the data folder, so that removing it makes room there."""


class FileSync:
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
        self._postponed: dict[str, float] = {}
        self._problem: str | None = None
        self._silence: str | None = None
        self._busy_since: float | None = None
        self._evicted_at = 0.0
        self._stopping = False
        self._log_once = LogOnce(_log, "Finished files cannot be shared")

    @property
    def problem(self) -> str | None:
        """A sentence while files cannot be copied; None: no problem."""
        return self._problem or self._silence

    def stop(self) -> None:
        """Stop; the next server repeats an unfinished copy."""
        self._stopping = True

    def tick(self) -> None:
        """Copy finished files, then make room; failures are logged."""
        self._busy_since = time.monotonic()
        try:
            self.upload_all()
            if time.monotonic() - self._evicted_at > _EVICTION_INTERVAL_S:
                self._evicted_at = time.monotonic()
                self.evict()
        except _Stopping:
            return
        except (SQLAlchemyError, OSError, SharedFilesError) as error:
            self._log_once.failed(error)
        finally:
            self._busy_since = self._silence = None

    def probe(self) -> None:
        """While a tick takes long, ask the shared files whether they answer at all, and keep the problem for pages."""
        began = self._busy_since
        if began is None or time.monotonic() - began < PROBE_INTERVAL_S:
            return
        silence = None
        try:
            self._files.store.require_answer()
        except SharedFilesError as error:
            silence = f"{error} {_STAYS}"
        if self._busy_since == began:  # otherwise the tick has ended meanwhile
            self._silence = silence

    def upload_all(self) -> None:
        """Copy all finished files that lie only on this server."""
        now = time.monotonic()
        self._postponed = {key: until for key, until in self._postponed.items() if until > now}
        if not self._postponed:
            self._problem = None
            self._log_once.recovered()
        for table, state in _STATES.items():
            with self._database.read() as session:
                query = select(table.id).where(table.place == self._database.server, table.state == state)
                waiting = session.scalars(query).all()
            for key in waiting:
                if key not in self._postponed and not self._try_upload(table, key):
                    return

    def evict(self) -> None:
        """Delete local files without a row, and above the limit also the shared ones that were not used for longest."""
        copies = self._files.local_copies()
        orphans = self._orphans(copies)
        for copy in orphans:
            self._files.remove_copy(copy)
        remaining = [copy for copy in copies if copy not in orphans]
        excess = sum(copy.size for copy in remaining) - self.cache_mb * 2**20
        for copy in remaining:
            if excess <= 0 or time.time() - copy.used < MIN_UNUSED_S:
                return
            try:
                is_shared = self._files.store.is_complete(copy.name)  # the shared copy is about to be the only one
            except SharedFilesError as error:
                self._log_once.failed(error)
                continue
            if is_shared:
                self._files.remove_copy(copy)
                excess -= copy.size

    # ------------------------------------------------------------------------------------------------------ inside

    def _try_upload(self, table: type[_Row], key: str) -> bool:
        """Copy the files of a row, or postpone it; False: the other rows should wait too."""
        try:
            with self._database.read() as session:
                row = cast(_Row | None, session.get(table, key))
            if row is not None:
                self._upload(table, row)
        except SharedFilesError as error:
            self._postponed[key] = time.monotonic() + RETRY_DELAY_S
            self._problem = f"{error} {_STAYS}"
            self._log_once.failed(error)
            return False
        except (OSError, VideoError) as error:  # the local files are damaged
            self._postponed[key] = time.monotonic() + RETRY_DELAY_S
            self._log_once.failed(error)
        return True

    def _upload(self, table: type[_Row], row: _Row) -> None:
        entries = list(self._entries_of(row))
        sizes = {}
        for entry in entries:
            files = self._files.store.put(entry.name, entry.path, self._wait)
            sizes[entry.name] = sum(size for size, _ in files.values())
            if isinstance(row, Video) and entry.name == f"videos/{row.id}" and files[""][1] != row.id:
                self._files.store.remove(entry.name)
                raise VideoError(f"{entry.path} has changed since it was added: it cannot be shared. Put it back.")
        with self._database.write() as session:
            found = cast(_Row | None, session.get(table, row.id, with_for_update=True))
            sent = found is not None and found.place == self._database.server and found.state == _STATES[table]
            if sent:
                assert found is not None
                found.place = self._database.shared
                _publish(session, self._events, found)
        if not sent:
            self._files.remove_in_background(*(entry.name for entry in entries))  # the row was removed meanwhile
            return
        for entry in entries:
            if entry.is_in_home:
                self._files.record_copy(entry.name, entry.path, sizes[entry.name])

    def _entries_of(self, row: _Row) -> Iterator[_Entry]:
        home = self._settings.home
        if isinstance(row, Video):
            file = library_file(self._settings, row)
            file.open().close()  # check that the file still has the video's bytes
            yield _Entry(f"videos/{row.id}", file.path, file.path.is_relative_to(home))
            for path in import_files(home, row.id):
                if path.is_file():
                    yield _Entry(str(path.relative_to(home)), path, True)
            return
        name = str(Path(row.path).parent) if isinstance(row, Output) else row.folder
        yield _Entry(name, home / name, True)

    def _wait(self) -> None:
        if self._stopping:
            raise _Stopping

    def _orphans(self, copies: list[LocalCopy]) -> list[LocalCopy]:
        """The kept files that no row names any more."""
        found: list[LocalCopy] = []
        for part in in_parts(copies):
            with self._database.read() as session:
                for table in _STATES:
                    of_table = [copy for copy in part if _ROWS_OF.get(copy.name.partition("/")[0], Video) is table]
                    query = select(table.id).where(table.id.in_({_id(copy) for copy in of_table}))
                    known_ids = set(session.scalars(query))
                    found += [copy for copy in of_table if _id(copy) not in known_ids]
        return found


def _id(copy: LocalCopy) -> str:
    return Path(copy.name).stem


def _publish(session: Session, events: EventBus, row: _Row) -> None:
    if isinstance(row, Video):
        publish_video(session, events, row)
    elif isinstance(row, Run):
        publish_run(session, events, row)
    elif isinstance(row, Output):
        publish_output(session, events, row)
    else:
        publish_model(session, events, row)
