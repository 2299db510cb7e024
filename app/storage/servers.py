"""Records which server has which files, if several servers share a database.

Each video, run, output, version of models and job has a place: the server that has the files, or the files that all
servers share (:mod:`app.files`). A job runs where its files are. A request to another server is answered with the name
of the right one.
"""

from __future__ import annotations

import logging
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from sqlalchemy import ColumnElement, or_, select, true, update
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import InstrumentedAttribute, Session

from app.errors import OnOtherServer
from app.storage.database import Database
from app.storage.id_lock import IdLock
from app.storage.models import ModelVersion, Output, Run, Server, Video
from tsr_engine.periodic import call_periodically

_log = logging.getLogger("tsr.server")
SHARED: Final = 0
"""Value of ``beats`` for shared files, which have no heartbeat and never count as dead."""


def this_server(session: Session) -> str | None:
    """This server; None: the database has only one."""
    server: str | None = session.connection().get_execution_options().get("tsr_server")
    return server


def shared_files_id(session: Session) -> str | None:
    """The files that this server shares with others; None: none."""
    shared: str | None = session.connection().get_execution_options().get("tsr_shared")
    return shared


def is_local(session: Session, place: InstrumentedAttribute[str | None]) -> ColumnElement[bool]:
    """Condition: the files lie on this server or in the shared files, or their place is unknown."""
    server, shared = this_server(session), shared_files_id(session)
    return true() if server is None else or_(place.is_(None), place.in_([p for p in (server, shared) if p is not None]))


def has_local_files(session: Session, place: str | None) -> bool:
    """Whether the files of one place lie on this server or in the shared files, or the place is unknown."""
    server = this_server(session)
    return server is None or place is None or place in (server, shared_files_id(session))


def require_local(session: Session, place: str | None, subject: str) -> None:
    """Refuse a request that needs files of another server.

    Args:
        session: reads.
        place: place of the row.
        subject: begins the sentence, for example the name of a run.

    Raises:
        OnOtherServer: the files lie elsewhere; the message names the server.
    """
    name = other_server(session, place, subject)
    if name is not None:
        raise OnOtherServer(
            f"The files of {subject or 'this'} lie on another server ({name}). Use that server.",
            details={"server": place, "name": name},
        )


def other_server(session: Session, place: str | None, subject: str) -> str | None:
    """Return the name of the other server that has the files; None: they lie here.

    Args:
        session: reads.
        place: place of the row.
        subject: begins the sentence, for example the name of a run.

    Raises:
        OnOtherServer: the files lie in shared files that this server does not use.
    """
    if has_local_files(session, place):
        return None
    server = session.get(Server, place)
    name = "unknown here" if server is None else server.name
    if server is not None and server.beats == SHARED:
        raise OnOtherServer(
            f"The files of {subject or 'this'} are in shared files ({name}). Set TSR_FILES to them for this server.",
            details={"server": place, "name": name},
        )
    return name


def waiting_note(session: Session, place: str | None) -> str:
    """What a job waits for if its files lie at a place, besides a free worker; empty: nothing."""
    if has_local_files(session, place):
        return ""
    server = session.get(Server, place)
    if server is not None and server.beats == SHARED:
        return f"servers with the shared files {server.name} have the video"
    return f"the server {'unknown here' if server is None else server.name} has the video"


def assign_local_files(database: Database, home: Path) -> None:
    """Assign rows without a place whose files lie here to this server; versions for one server stored no place."""
    server = database.server
    if server is None:
        return
    with database.write() as session:
        for video in session.scalars(select(Video).where(Video.place.is_(None))):
            video.place = server if Path(video.path).is_file() else None
        for run in session.scalars(select(Run).where(Run.place.is_(None), Run.folder != "")):
            run.place = server if (home / run.folder).is_dir() else None
        for output in session.scalars(select(Output).where(Output.place.is_(None), Output.path != "")):
            output.place = server if (home / output.path).is_file() else None
        for version in session.scalars(select(ModelVersion).where(ModelVersion.place.is_(None))):
            version.place = server if (home / version.folder).is_dir() else None


class Servers:
    """The servers of one database, as seen by this one; thread-safe.

    Each server increments its row now and then. Clocks of machines differ, so only the change of the number counts,
    timed by this machine's steady clock.
    """

    heartbeat_interval = 15.0
    """Seconds between heartbeats."""
    heartbeat_timeout = 120.0
    """Seconds without a heartbeat after which a server counts as dead."""
    refusal_delay = 60.0
    """Seconds that the database may take to end this server's own lost connection, which holds the id."""

    def __init__(self, database: Database, home: Path) -> None:
        self._database = database
        self._name = f"{socket.gethostname()}:{home}"
        self._id_lock = IdLock(database)
        self._lock = threading.Lock()
        self._seen: dict[str, tuple[int, float]] = {}
        self._shared: set[str] = set()
        self._refused_since: float | None = None
        """Time of the first of the latest refusals of the id; None: it has the id."""

    def register(self) -> None:
        """Register this server as the only one with its id.

        Raises:
            StorageError: another server has the id.
        """
        self._id_lock.acquire()

    def store_shared_address(self, name: str) -> None:
        """Store the address of the shared files for other servers."""
        shared = self._database.shared
        if shared is not None:
            with self._database.write() as session:
                if session.get(Server, shared) is None:
                    session.add(Server(id=shared, name=name, beats=SHARED))

    def unregister(self) -> None:
        """Release the id."""
        self._id_lock.release()

    @contextmanager
    def heartbeat(self) -> Iterator[None]:
        """Send heartbeats until the block ends."""
        if self._database.server is None:
            yield
            return
        self.beat()
        with call_periodically("server", self.heartbeat_interval, self._try_heartbeat):
            yield

    def beat(self) -> None:
        """Send a heartbeat, and read those of the others."""
        server_id = self._database.server
        with self._database.write() as session:
            own_row = update(Server).where(Server.id == server_id).values(beats=Server.beats + 1, name=self._name)
            if not session.execute(own_row).rowcount:  # type: ignore[attr-defined]
                session.add(Server(id=server_id, name=self._name, beats=1))
                session.flush()
            beats = {server.id: server.beats for server in session.scalars(select(Server))}
        self._shared = {server for server, count in beats.items() if count == SHARED}
        now = time.monotonic()
        with self._lock:
            for server, count in beats.items():
                if self._seen.get(server, (-1, 0.0))[0] != count:
                    self._seen[server] = count, now

    def is_dead(self, server: str | None) -> bool:
        """Whether a server has sent no heartbeat for long; an unknown server is dead."""
        if server in self._shared:
            return False
        with self._lock:
            seen = self._seen.get(server or "")
        return seen is None or time.monotonic() - seen[1] > self.heartbeat_timeout

    def _try_heartbeat(self) -> None:
        with suppress(SQLAlchemyError):  # the next heartbeat may succeed again
            now = time.monotonic()
            self._refused_since = None if self._id_lock.ensure() else self._refused_since or now
            if self._refused_since is not None and now - self._refused_since >= self.refusal_delay:
                _log.error("Another server uses the id of this data folder: one is a copy of the other. Stop one.")
            self.beat()
