"""People who edit one run at once, and checks of the database afterwards."""

from __future__ import annotations

import json
import random
import threading
import time
import uuid
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from http.client import HTTPException, HTTPMessage
from pathlib import Path

from sqlalchemy import select

from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Edit, TrackDocument
from tests.attack.server_process import PersistentConnection, ServerProcess

__all__ = ["AnswerLog", "BrokenGuaranteeError", "TrackedLibrary", "check_log", "clients"]

PEOPLE_PER_TRACK = 3
"""People on each track."""
MAX_PAUSE_S = 0.2
"""Seconds from an answer to the next edit of somebody in a hurry, at most; half of it on average."""


class BrokenGuaranteeError(Exception):
    """The database breaks a guarantee."""


@dataclass
class AnswerLog:
    """Answers that the clients received.

    Attributes:
        acknowledged: operations that the server answered with 200.
        refused: count of each other status.
        waits: seconds of each answered edit.
        handled: the server's seconds for each edit, from the complete request head to the answer's head.
    """

    acknowledged: set[str] = field(default_factory=set)
    refused: Counter[int] = field(default_factory=Counter)
    waits: list[float] = field(default_factory=list)
    handled: list[float] = field(default_factory=list)

    def record_timing(self, headers: HTTPMessage) -> None:
        """Record the server's own time measurement."""
        self.handled.append(float(headers["Server-Timing"].partition("dur=")[2]) / 1000)


@dataclass(frozen=True)
class TrackedLibrary:
    """A data folder with one run.

    Attributes:
        home: the folder.
        video: the video's id.
        run: the run's id.
        tracks: keys of the run's tracks, each with a frame in which it is visible.
        database_url: PostgreSQL; None: SQLite in the folder.
        people: names and tokens of editors; none: a library without people.
    """

    home: Path
    video: str
    run: str
    tracks: tuple[tuple[str, int], ...]
    database_url: str | None = None
    people: tuple[tuple[str, str], ...] = ()

    @property
    def environment(self) -> dict[str, str]:
        """Environment variables of a server on this folder."""
        return {} if self.database_url is None else {"TSR_DATABASE_URL": self.database_url}


def client(
    library: TrackedLibrary,
    server: Callable[[], ServerProcess],
    log: AnswerLog,
    number: int,
    rng: random.Random,
    max_pause_s: float,
    done: threading.Event,
) -> None:
    """Edit one track until the end, as the page does: follow the answers' revisions and resend unanswered edits."""
    author, token = library.people[number % len(library.people)] if library.people else (f"client-{number}", "")
    more = {"Authorization": f"Bearer {token}"} if token else {}
    key, frame = library.tracks[number // PEOPLE_PER_TRACK % len(library.tracks)]
    line, revision = PersistentConnection(server, more), -1
    while not done.is_set():
        op_id = uuid.UUID(int=rng.getrandbits(128)).hex
        command = {"name": "relabel_track", "key": key, "frame": frame, "class_id": rng.randrange(43)}
        while not done.is_set():
            try:
                if revision < 0:
                    _, answer, _ = line.request(f"/api/runs/{library.run}/annotation")
                    revision = next((doc["revision"] for doc in answer["docs"] if doc["key"] == key), 0)
                body = json.dumps({"op_id": op_id, "author": author, "command": command}).encode()
                headers = {"If-Match": f'"{key}:{revision}"', "Content-Type": "application/json"}
                began = time.monotonic()
                status, answer, heard = line.request(f"/api/runs/{library.run}/edits", body, headers)
            except (OSError, HTTPException, ValueError, KeyError):
                time.sleep(0.05)  # the server is down: send the same operation again
                continue
            if status == 200:
                log.acknowledged.add(op_id)
                log.waits.append(time.monotonic() - began)
                log.record_timing(heard)
                revision = answer["docs"][0]["revision"]
                done.wait(rng.uniform(0, max_pause_s))
                break
            log.refused[status] += 1
            if status not in (409, 412, 503, 507):
                raise BrokenGuaranteeError(f"an edit was answered with {status}: {answer}")
            if status in (409, 412):  # a person reads the track again and decides anew
                current = (answer["error"]["details"] or {}).get("current") or [{"revision": -1}]
                op_id, revision = uuid.UUID(int=rng.getrandbits(128)).hex, current[0]["revision"]
                done.wait(rng.uniform(0, max_pause_s))
            else:
                time.sleep(0.1)
    line.close()


@contextmanager
def clients(
    library: TrackedLibrary,
    server: Callable[[], ServerProcess],
    log: AnswerLog,
    count: int,
    rng: random.Random,
    max_pause_s: float = MAX_PAUSE_S,
) -> Iterator[None]:
    """Clients that edit in the meantime; their errors are raised at the end."""
    done, broken = threading.Event(), list[BaseException]()
    seeds = [rng.getrandbits(64) for _ in range(count)]

    def work(number: int) -> None:
        try:
            client(library, server, log, number, random.Random(seeds[number]), max_pause_s, done)
        except BaseException as error:
            broken.append(error)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    try:
        yield
    finally:
        done.set()
        for thread in threads:
            thread.join()
    if broken:
        raise broken[0]


def check_log(library: TrackedLibrary, log: AnswerLog) -> int:
    """Check that every acknowledged operation is stored once and took effect once.

    Returns:
        The number of operations stored.

    Raises:
        BrokenGuaranteeError: an operation is lost or doubled, or the database is damaged.
    """
    settings = Settings(home=library.home, database_url=library.database_url)
    database = Database(settings.database)
    with closing(database), database.read() as session:
        if database.is_sqlite:
            sound = session.connection().exec_driver_sql("PRAGMA integrity_check").fetchall()
            if sound != [("ok",)]:
                raise BrokenGuaranteeError(f"the database is damaged: {sound[:3]}")
        edits = session.scalars(select(Edit).where(Edit.run_id == library.run).order_by(Edit.seq)).all()
        documents = session.scalars(select(TrackDocument).where(TrackDocument.run_id == library.run)).all()
    stored = Counter(edit.op_id for edit in edits)
    lost = log.acknowledged - stored.keys()
    twice = [op_id for op_id, count in stored.items() if count > 1]
    if lost or twice:
        raise BrokenGuaranteeError(f"{len(lost)} acknowledged edits lost, {len(twice)} stored twice")
    # each edit starts from the state that the previous one left, and the last one's state is stored
    newest = dict[str, object]()
    for edit in edits:
        for key, before in edit.before.items():
            if key in newest and before != newest[key]:
                raise BrokenGuaranteeError(f"the edit {edit.op_id} of {key} does not follow on the one before it")
        newest.update(edit.after)
    left = {row.key: row.document for row in documents}
    if any(left.get(key) != document for key, document in newest.items()):
        raise BrokenGuaranteeError("a track is not as its last edit has left it")
    return len(edits)
