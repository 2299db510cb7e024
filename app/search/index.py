"""Keeps the tables of the search in step with runs, edits and label sets.

The index follows the stream of events and the edit log, which record every change of a run. Each run is read in its own
transaction, so an interrupted update continues where it was.
"""

from __future__ import annotations

import functools
import logging
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress

from sqlalchemy import case, delete, func, insert, select, update
from sqlalchemy.exc import IntegrityError, SQLAlchemyError
from sqlalchemy.orm import Session

from app.edits.log_store import documents_of
from app.errors import ApiError, NotFound
from app.evidence.service import EvidenceService
from app.exchange.tracks import run_tracks
from app.log_once import LogOnce
from app.search.rows import LastEdit, Rows, make_rows
from app.search.stale import ExpectedRun, expected_runs, runs_have_changed, stale_runs
from app.storage.database import Database
from app.storage.lookup import in_parts
from app.storage.models import Edit, Event, SearchAttribute, SearchRun, SearchTrack, Video
from tsr_engine.errors import TsrError
from tsr_engine.exchange.dataset import Track

_TICK_S = 1.0
"""Seconds of reading runs in the background before a search gets its turn."""
_NO_END = 2**31 - 2
_log = logging.getLogger("tsr.search")


class _Stopping(Exception):
    """The server ends."""


class SearchIndex:
    """Updates the tables of the search; thread-safe, one per process."""

    def __init__(self, database: Database, evidence: EvidenceService) -> None:
        self._database = database
        self._evidence = evidence
        self._lock = threading.Lock()
        self._numbers = database.polled(_newest)
        self._checked_numbers: tuple[int, int] | None = None
        self._event = -1
        self._edit = 0
        self._expected: dict[str, ExpectedRun] = {}
        self._unread: list[str] = []
        self._edited: dict[str, int] = {}
        """Runs with edits that the tables lack -> number of the newest edit."""
        self._stopping = False
        self._log_once = LogOnce(_log, "The search cannot be updated")

    def stop(self) -> None:
        """Stop; the next server reads an unfinished run again."""
        self._stopping = True

    def tick(self) -> None:
        """Update for at most a second; failures are logged."""
        try:
            self.update(_TICK_S)
        except (SQLAlchemyError, OSError) as error:
            self._log_once.failed(error)
        else:
            self._log_once.recovered()

    def update(self, seconds: float) -> int:
        """Update the tables for at most some seconds.

        Returns:
            Number of runs that still have to be read.
        """
        deadline = time.monotonic() + seconds
        if self._lock.acquire(timeout=seconds):
            try:
                self._find_changes()
                while (self._edited or self._unread) and time.monotonic() < deadline:
                    self._read_next()
            except _Stopping:
                pass
            finally:
                self._lock.release()
        return len(self._unread) + len(self._edited)

    def unread_current_runs(self) -> set[str]:
        """Current runs of videos that still have to be read."""
        # without the lock: callers must not wait for a long run that is being read
        keys, expected = {*list(self._unread), *list(self._edited)}, self._expected
        return {key for key in keys if (run := expected.get(key)) and run.current}

    def read_all(self, progress: Callable[[int, int], None], *, rebuild: bool = False) -> None:
        """Update the tables completely.

        Args:
            progress: called with (runs read, runs to read).
            rebuild: also read known runs again.
        """
        remaining = total = self.update(0.0)
        if rebuild:
            with self._lock:
                self._unread = list(self._expected)
                remaining = total = len(self._unread)
        while remaining:
            progress(total - remaining, total)
            remaining = self.update(_TICK_S)
            total = max(total, remaining)
        progress(total, total)

    # ------------------------------------------------------------------------------------------------------ inside

    def _find_changes(self) -> None:
        """Find out which runs must be read."""
        numbers = self._numbers()
        if numbers == self._checked_numbers:
            return
        event, _ = numbers
        with self._database.read() as session:
            changed = self._event < 0 or (event != self._event and runs_have_changed(session, self._event))
            flags: dict[str, bool] = {}
            if changed:
                self._edit = 0  # SQLite gives the numbers of a removed run's edits to later ones
                self._expected = expected_runs(session)
                self._unread, flags = stale_runs(session, self._expected, retry=self._event < 0)
                if self._database.shared is not None:  # runs that must be fetched come last
                    self._unread.sort(key=lambda run_id: not self._evidence.has_local_files(run_id))
            newest = session.execute(
                select(Edit.run_id, func.max(Edit.seq)).where(Edit.seq > self._edit).group_by(Edit.run_id)
            ).all()
            if newest:
                self._edited |= {run_id: seq for run_id, seq in newest if run_id in self._expected}
                known = self._seqs(session, list(self._edited))
                self._edited = {run: seq for run, seq in self._edited.items() if known.get(run, seq) < seq}
        if flags:
            self._store_current_flags(flags)
        self._event = event
        self._edit = max([self._edit, *(seq for _, seq in newest)])
        self._checked_numbers = numbers

    def _read_next(self) -> None:
        """Read one run; runs with new edits first, because a person may wait for them."""
        run_id = next(iter(self._edited)) if self._edited else self._unread[0]
        whole = run_id in self._unread
        expected = self._expected.get(run_id)
        if expected is not None and not (whole and self._read_elsewhere(expected)):
            try:
                self._read(expected, whole=whole)
            except NotFound:  # it was removed
                pass
            except IntegrityError as error:
                self._record_failure(expected, error)
        self._edited.pop(run_id, None)
        if whole:
            self._unread.remove(run_id)

    def _read_elsewhere(self, expected: ExpectedRun) -> bool:
        """Whether another server has read a run of the shared files meanwhile, so that it need not be fetched."""
        if self._database.shared is None or self._evidence.has_local_files(expected.run_id):
            return False
        with self._database.read() as session:
            row = session.get(SearchRun, expected.run_id)
            return row is not None and row.error is None and row.basis == expected.basis

    def _read(self, expected: ExpectedRun, *, whole: bool) -> None:
        try:
            seq, keys, rows = self._rows(expected, whole=whole)
        except (NotFound, SQLAlchemyError, _Stopping):
            raise
        except Exception as error:  # noqa: BLE001 - one damaged run must not keep the others from being found
            if not isinstance(error, ApiError | TsrError | OSError):
                _log.warning("The run %s cannot be read.", expected.run_id, exc_info=error)
            reason = error.message if isinstance(error, ApiError) else str(error) or type(error).__name__
            self._store(expected, 0, None, Rows([], []), reason)
        else:
            self._store(expected, seq, keys, rows, None)

    def _record_failure(self, expected: ExpectedRun, error: IntegrityError) -> None:
        """Record why a run is not in the tables, unless it was removed or another server was faster."""
        with self._database.read() as session:
            if expected.run_id in self._seqs(session, [expected.run_id]):
                return
        _log.warning("The run %s cannot be stored for the search.", expected.run_id, exc_info=error)
        with suppress(IntegrityError):  # it was removed
            self._store(expected, 0, None, Rows([], []), "Its tracks cannot be stored for the search.")

    def _rows(self, expected: ExpectedRun, *, whole: bool) -> tuple[int, list[str] | None, Rows]:
        """Number of the newest edit; keys of the tracks with rows, None: all; their rows."""
        run_id = expected.run_id
        run = self._evidence.stored_run(run_id)
        known: dict[str, float] = {}
        with self._database.read() as session:
            row = None if whole else session.get(SearchRun, run_id)
            row = None if row is None or row.error is not None else row
            after = 0 if row is None else row.seq
            edits, seq = _last_edits(session, run_id, after)
            keys = None if row is None else sorted(edits)
            documents = documents_of(session, run_id, keys)
            video = session.get_one(Video, expected.video_id)
            frames, picture = video.frames or _NO_END, (video.width or 0, video.height or 0)
            if keys is not None:
                tracks = (doc.original_track() for doc in documents.values())
                known = _uncertainties(
                    session, run_id, [*keys, *{f"m{track}" for track in tracks if track is not None}]
                )

        @functools.cache  # cached, because an imported run has none and one read is enough
        def engine_uncertainties() -> dict[int, float]:
            return self._evidence.uncertainties(run_id)

        def uncertainty(key: str, engine_track: int) -> float:
            found = known.get(f"m{engine_track}", known.get(key))
            return engine_uncertainties().get(engine_track, 0.0) if found is None else found

        found = run_tracks(run.folder, documents, 0, frames, frames, to_label=run.classes.to_label, keys=keys)
        rows = make_rows(
            self._until_stopped(found),
            documents,
            edits,
            uncertainty,
            lambda number: self._evidence.label(run_id, number),
            picture,
        )
        return seq, keys, rows

    def _until_stopped(self, tracks: Iterable[Track]) -> Iterator[Track]:
        for track in tracks:
            if self._stopping:
                raise _Stopping
            yield track

    def _store(
        self, expected: ExpectedRun, seq: int, keys: Sequence[str] | None, rows: Rows, error: str | None
    ) -> None:
        run_id = expected.run_id
        run_columns = {name: getattr(expected, name) for name in ("run_id", "video_id", "set_key", "current")}
        with self._database.write() as session:
            for table in (SearchAttribute, SearchTrack):
                for part in [None] if keys is None else in_parts(keys):
                    old = delete(table).where(table.run_id == run_id)
                    session.execute(old if part is None else old.where(table.key.in_(part)))
            session.execute(delete(SearchRun).where(SearchRun.run_id == run_id))
            session.execute(insert(SearchRun).values(**run_columns, basis=expected.basis, seq=seq, error=error))
            if rows.tracks:
                session.execute(insert(SearchTrack), [run_columns | row for row in rows.tracks])
            if rows.attributes:
                session.execute(insert(SearchAttribute), [{"run_id": run_id} | row for row in rows.attributes])
            count_tracks(session, run_id)

    def _store_current_flags(self, flags: dict[str, bool]) -> None:
        with self._database.write() as session:
            for run_id, current in flags.items():
                for table in (SearchRun, SearchTrack):
                    session.execute(update(table).where(table.run_id == run_id).values(current=current))

    @staticmethod
    def _seqs(session: Session, runs: Sequence[str]) -> dict[str, int]:
        found: dict[str, int] = {}
        for part in in_parts(runs):
            query = select(SearchRun.run_id, SearchRun.seq).where(SearchRun.run_id.in_(part))
            found |= {row[0]: row[1] for row in session.execute(query)}
        return found


def _newest(session: Session) -> tuple[int, int]:
    """Numbers of the newest event and the newest edit; 0: none yet."""
    return session.scalar(select(func.max(Event.seq))) or 0, session.scalar(select(func.max(Edit.seq))) or 0


def count_tracks(session: Session, run_id: str) -> None:
    """Store the number of a run's tracks and notes in its row, so that an overview sums over runs, not tracks."""
    row = SearchTrack
    lines = func.length(row.notes) - func.length(func.replace(row.notes, "\n", "")) + 1
    counted = {
        "tracks": case((row.state != "ignored", 1), else_=0),
        "accepted": case((row.state == "accepted", 1), else_=0),
        "rejected": case((row.state == "rejected", 1), else_=0),
        "notes": case((row.notes != "", lines), else_=0),
    }
    sums = (func.coalesce(func.sum(each), 0).label(name) for name, each in counted.items())
    found = session.execute(select(*sums).where(row.run_id == run_id)).one()
    session.execute(update(SearchRun).where(SearchRun.run_id == run_id).values(found._asdict()))


def _last_edits(session: Session, run_id: str, after: int) -> tuple[dict[str, LastEdit], int]:
    """Newest edit of each track that was edited after a number, and the newest number."""
    found: dict[str, LastEdit] = {}
    query = select(Edit.seq, Edit.author, Edit.created, Edit.after).where(Edit.run_id == run_id, Edit.seq > after)
    for seq, author, created, documents in session.execute(query.order_by(Edit.seq)):
        after = seq
        found |= dict.fromkeys(documents, LastEdit(author, int(created.timestamp())))
    return found, after


def _uncertainties(session: Session, run_id: str, keys: Sequence[str]) -> dict[str, float]:
    """Uncertainties in the tables, from before any edits."""
    found: dict[str, float] = {}
    for part in in_parts(keys):
        by_keys = SearchTrack.run_id == run_id, SearchTrack.key.in_(part)
        query = select(SearchTrack.key, SearchTrack.engine_uncertainty).where(*by_keys)
        found |= {row[0]: row[1] for row in session.execute(query)}
    return found
