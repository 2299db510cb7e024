"""The edit log and its documents in the database, and their locks.

Edits that could conflict wait for each other; all others run in parallel. SQLite has one writer at a time anyway.
PostgreSQL's advisory locks are always taken in the order of this module, and before the lock on the order of events, so
there is no deadlock.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Iterable, Mapping, Sequence

from sqlalchemy import Select, TextClause, bindparam, select, text
from sqlalchemy.orm import Session

from app.edits.counters import Change, add_to_totals, count_reviewed
from app.edits.documents import OPEN_END, TrackDoc, engine_doc
from app.errors import Conflict
from app.events import EventBus
from app.evidence.service import EvidenceService
from app.settings import Settings
from app.storage.database import Database
from app.storage.lookup import in_parts, require_run
from app.storage.models import Edit, Run, TrackDocument, Video
from app.videos.file_changes import ChangedFiles

_MAX_SINGLE_LOADS = 50
"""Up to this many documents are loaded one by one; most are in the session already."""
_MAX_REPORTED = 500
"""Maximum number of documents of one operation in the stream of events."""
# built once: building the query takes longer than running it
_RUN_AND_EDIT = (
    select(Run, Video, Edit)
    .join(Video, Video.id == Run.video_id)
    .outerjoin(Edit, Edit.op_id == bindparam("op"))
    .where(Run.id == bindparam("run"))
)
_DOCUMENTS_BY_KEYS = select(TrackDocument).where(
    TrackDocument.run_id == bindparam("run"), TrackDocument.key.in_(bindparam("keys", expanding=True))
)
_DOCUMENTS_TO_CHANGE = _DOCUMENTS_BY_KEYS.with_for_update()


class LogStore:
    """The append-only log of all runs, and their current documents; works in the caller's transaction.

    Attributes:
        database: holds log and documents.
        evidence: reads the engine's tracks.
    """

    def __init__(
        self, database: Database, events: EventBus, evidence: EvidenceService, settings: Settings | None = None
    ) -> None:
        self.database = database
        self.evidence = evidence
        self._events = events
        self._files = ChangedFiles(settings or Settings(), database)

    def require_unchanged_file(self, run_id: str, op_id: str | None = None) -> None:
        """Refuse new operations on a run whose video's file was replaced.

        It may read the whole file or fetch the evidence, so it is called before a transaction that others wait for.

        Args:
            run_id: the run.
            op_id: an operation that is still answered if it was stored before the file changed.

        Raises:
            Conflict: the file was replaced (``file_changed``).
            Busy: the evidence is still being fetched.
        """
        try:
            self._files.refuse(run_id)
            if self.database.shared is not None:
                self.evidence.stored_run(run_id)
        except Conflict:
            if op_id is None:
                raise
            with self.database.read() as session:
                if session.scalars(select(Edit.seq).where(Edit.op_id == op_id)).first() is None:
                    raise

    @staticmethod
    def load_run(session: Session, run_id: str, op_id: str) -> tuple[Run, Edit | None]:
        """Load the run, and the operation ``op_id`` if it is stored already, in one query.

        The run's video is loaded too, so that the session returns it without another query.

        Raises:
            NotFound: no such run.
            Conflict: the operation belongs to another run.
        """
        row = session.execute(_RUN_AND_EDIT, {"run": run_id, "op": op_id}).first()
        if row is None:
            return require_run(session, run_id), None
        run, session.info["video"], edit = row  # a session drops objects without references
        if edit is not None and edit.run_id != run_id:
            raise Conflict("This op_id belongs to an operation on another run. Choose a new one.", code="op_id_used")
        return run, edit

    def load(self, session: Session, run: Run, keys: Sequence[str], *, change: bool = True) -> dict[str, TrackDoc]:
        """Load documents of existing tracks; untouched engine tracks get a new one.

        Args:
            session: of the transaction.
            run: the run.
            keys: keys of the tracks.
            change: they will be saved, so lock them until the transaction ends.
        """
        rows = session.scalars(
            _DOCUMENTS_TO_CHANGE if change else _DOCUMENTS_BY_KEYS, {"run": run.id, "keys": keys}
        ).all()
        if change:
            session.info["documents"] = rows  # references, so that save finds them without another query
        found = {row.key: self.close_segments(run, _doc_of(row)) for row in rows}
        missing = [key for key in keys if key not in found and key.startswith("m")]
        spans = self.evidence.all_spans(run.id) if len(missing) > _MAX_SINGLE_LOADS else None
        for key in missing:
            document = self.untouched_document(run, key, spans)
            if document is not None:
                found[key] = document
        return found

    def edited_documents(self, session: Session, run: Run) -> dict[str, TrackDoc]:
        """Load the documents of all tracks that people have corrected."""
        return {row.key: self.close_segments(run, _doc_of(row)) for row in session.scalars(_documents(run.id))}

    def close_segments(self, run: Run, doc: TrackDoc) -> TrackDoc:
        """Set the end of open segments to the end of their tracks once the run is complete."""
        if run.state != "complete" or all(piece.last < OPEN_END for piece in doc.segments):
            return doc
        pieces = []
        for piece in doc.segments:
            span = self.evidence.span(run.id, piece.track) if piece.last >= OPEN_END else (piece.first, piece.last)
            if span is not None and piece.first <= span[1]:
                pieces.append(piece.model_copy(update={"last": span[1]}))
        return doc.model_copy(update={"segments": tuple(pieces)})

    def untouched_document(
        self, run: Run, key: str, spans: Mapping[int, tuple[int, int]] | None = None
    ) -> TrackDoc | None:
        """Make the untouched document of an engine track, with an open end while the run goes on; None: no such track.

        Args:
            run: the run.
            key: key of the track.
            spans: first and last frame of all engine tracks, if already known.
        """
        if not key.startswith("m"):
            return None
        track = int(key[1:])
        if key != f"m{track}":  # "m007" would be another name of m7, whose revision nobody checks
            return None
        span = self.evidence.span(run.id, track) if spans is None else spans.get(track)
        if span is None:
            return None
        return engine_doc(track, span[0], span[1] if run.state == "complete" else OPEN_END)

    def append(
        self,
        session: Session,
        run: Run,
        author: str,
        command: Mapping[str, object],
        before: Mapping[str, TrackDoc | None],
        after: Mapping[str, TrackDoc],
        frame: int | None,
        *,
        op_id: str,
        reverts: str | None = None,
    ) -> tuple[Edit, dict[str, TrackDoc]]:
        """Save documents, and append the operation to the log and to the stream of events.

        Call it last in a transaction, because other writers wait once it has drawn the number. It sends the documents
        before that.

        Args:
            session: of the transaction.
            run: the run.
            author: author of the operation.
            command: the command to log; ``name`` is the kind of operation.
            before: documents before, by key; None: there was none.
            after: documents after, by key.
            frame: frame to show for the operation; None: it has none.
            op_id: id of the operation.
            reverts: the operation that it undoes or redoes.

        Returns:
            The operation, and the documents as stored.
        """
        saved, changes = self._save(session, run.id, before, after)
        row = Edit(
            op_id=op_id,
            run_id=run.id,
            author=author,
            kind=command["name"],
            command=dict(command),
            frame=frame,
            before={key: None if doc is None else doc.model_dump(mode="json") for key, doc in before.items()},
            after={key: document for key, _, document in changes},
            reverts=reverts,
        )
        session.flush()
        self._events.order(session)
        session.add(row)
        session.flush()
        count_reviewed(session, run.id, changes)
        add_to_totals(session, row)
        docs = list(row.after.values()) if len(row.after) <= _MAX_REPORTED else None  # pages request larger operations
        event = {"seq": row.seq, "op_id": op_id, "author": author, "docs": docs}
        self._events.publish(session, "edit", run.id, event)
        return row, saved

    @staticmethod
    def _save(
        session: Session, run_id: str, before: Mapping[str, TrackDoc | None], after: Mapping[str, TrackDoc]
    ) -> tuple[dict[str, TrackDoc], list[Change]]:
        """Store documents with their next revision; return them as stored, and the changes."""
        saved: dict[str, TrackDoc] = {}
        changes: list[Change] = []
        rows = _stored_rows(session, run_id, list(after)) if len(after) > _MAX_SINGLE_LOADS else None
        for key, doc in after.items():
            old = before.get(key)
            row = session.get(TrackDocument, (run_id, key)) if rows is None else rows.get(key)
            revision = max(0 if old is None else old.revision, 0 if row is None else row.revision) + 1
            saved[key] = doc.model_copy(update={"revision": revision})
            if row is None:
                row = TrackDocument(run_id=run_id, key=key)
                session.add(row)
            document = saved[key].model_dump(mode="json")
            changes.append((key, row.document, document))
            row.document, row.revision = document, revision
        return saved, changes


def documents_of(session: Session, run_id: str, keys: Sequence[str] | None = None) -> dict[str, TrackDoc]:
    """Load the documents of a run, or of some of its tracks, by key."""
    rows = session.scalars(_documents(run_id)) if keys is None else _stored_rows(session, run_id, keys).values()
    return {row.key: _doc_of(row) for row in rows}


def lock_for_edit(session: Session, run_id: str, op_id: str, author: str, keys: Iterable[str] = ()) -> None:
    """Lock an operation, its author and its tracks in the run until the transaction ends."""
    exclusive = [f"op {op_id}", f"author {run_id} {author}"]
    _acquire(session, exclusive, shared=[f"run {run_id}"], last=[f"track {run_id} {key}" for key in sorted(keys)])


def lock_tracks(session: Session, run_id: str, keys: Iterable[str]) -> None:
    """Lock further tracks after a :func:`lock_for_edit` without tracks."""
    _acquire(session, [f"track {run_id} {key}" for key in sorted(keys)])


def lock_for_many(session: Session, run_id: str, op_id: str, author: str) -> None:
    """Lock an operation, its author and the whole run until the transaction ends."""
    _acquire(session, [f"op {op_id}", f"author {run_id} {author}", f"run {run_id}"])


def lock_run(session: Session, run_id: str) -> None:
    """Lock all tracks of a run."""
    _acquire(session, [f"run {run_id}"])


def _acquire(session: Session, names: list[str], shared: Sequence[str] = (), last: Sequence[str] = ()) -> None:
    if session.get_bind().dialect.name == "postgresql" and (names or shared or last):
        numbers = {f"n{index}": _number(name) for index, name in enumerate([*names, *shared, *last])}
        session.connection().execute(_locks(len(names), len(shared), len(last)), numbers)


@functools.lru_cache
def _locks(names: int, shared: int, last: int) -> TextClause:
    """The query that takes so many locks, one after the other."""
    kinds = ["pg_advisory_xact_lock"] * names + ["pg_advisory_xact_lock_shared"] * shared
    kinds += ["pg_advisory_xact_lock"] * last
    return text("SELECT " + ", ".join(f"{kind}(:n{index})" for index, kind in enumerate(kinds)))


def _number(name: str) -> int:
    """63 bits of a name's hash; two names with one number only wait for each other without need."""
    return int.from_bytes(hashlib.blake2b(name.encode(), digest_size=8).digest(), "big") >> 1


def _stored_rows(session: Session, run_id: str, keys: Sequence[str]) -> dict[str, TrackDocument]:
    """Load the rows of many documents in few queries."""
    found = {}
    for part in in_parts(keys):
        rows = session.scalars(_DOCUMENTS_BY_KEYS, {"run": run_id, "keys": part})
        found.update({row.key: row for row in rows})
    return found


def _documents(run_id: str) -> Select[TrackDocument]:
    return select(TrackDocument).where(TrackDocument.run_id == run_id)


def _doc_of(row: TrackDocument) -> TrackDoc:
    return TrackDoc.model_validate({**row.document, "revision": row.revision})
