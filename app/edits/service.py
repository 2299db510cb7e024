"""Edits of a run: checked against what they were made for, logged, applied, told, all in one transaction."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any
from uuid import uuid4

import numpy as np
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.edits.adopt import EngineRun, adopt_documents
from app.edits.apply import CommandError, apply_command, touched_keys, with_class
from app.edits.commands import Redo, SetAttribute, Undo
from app.edits.documents import TrackDoc
from app.edits.extent import known_frames, require_documents_inside, require_inside
from app.edits.history import Target, adopted_keys, last_said, targets
from app.edits.labelled import by_key, require_attribute, require_known_labels
from app.edits.locks import lock_for_adoption, lock_for_edit, lock_for_many, lock_tracks
from app.edits.present import PresentDocuments
from app.edits.revisions import check_revisions
from app.edits.stored import documents_of
from app.edits.views import AdoptConflict, Adopted, Annotation, EditAnswer, LogEntry, adopted, log_entry
from app.errors import Conflict, Invalid, NotFound
from app.events import EventBus
from app.evidence.service import EvidenceService
from app.labels.store import labels_of_run
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Edit, Run
from app.videos.same_file import ChangedFiles
from tsr_engine.track_table import TrackTable

__all__ = ["AdoptConflict", "Adopted", "Annotation", "EditAnswer", "EditService", "LogEntry", "TracksChanged"]

_MOST_REPORTED = 500
"""Documents that the stream of events carries of one operation."""


@dataclass(frozen=True, slots=True)
class TracksChanged:
    """What became of an operation on many tracks.

    Attributes:
        changed: keys; empty: nothing was stored.
        stayed: key -> why, as the end of a sentence without its full stop.
    """

    changed: list[str]
    stayed: dict[str, str]


class EditService:
    """The append-only log and the documents that follow from it."""

    def __init__(
        self,
        database: Database,
        events: EventBus,
        evidence: EvidenceService,
        settings: Settings | None = None,
    ) -> None:
        """Take what the service stands on.

        Args:
            database: holds log and documents.
            events: tells the pages.
            evidence: knows the engine's tracks.
            settings: where the videos lie.
        """
        self._database = database
        self._events = events
        self._evidence = evidence
        self._files = ChangedFiles(settings or Settings(), database)
        self._present = PresentDocuments(evidence)

    def annotation(self, run_id: str, author: str) -> Annotation:
        """All documents of a run, and what ``author`` can undo.

        Raises:
            NotFound: no such run.
        """
        with self._database.read() as session:
            _require_run(session, run_id)
            return self._annotated(session, run_id, author, list(documents_of(session, run_id).values()))

    def documents(self, run_id: str) -> dict[str, TrackDoc]:
        """All documents of a run by key."""
        with self._database.read() as session:
            return documents_of(session, run_id)

    def log(self, run_id: str, after: int, most: int = 1000) -> list[LogEntry]:
        """Rows of the log after a number.

        Raises:
            NotFound: no such run.
        """
        with self._database.read() as session:
            _require_run(session, run_id)
            query = select(Edit).where(Edit.run_id == run_id, Edit.seq > after).order_by(Edit.seq).limit(most)
            return [log_entry(edit) for edit in session.scalars(query)]

    def apply(
        self, run_id: str, op_id: str, author: str, command: Any, expected: Mapping[str, int] | None
    ) -> EditAnswer:
        """Carry out one operation; the same ``op_id`` again gives the first answer again.

        Args:
            run_id: the run.
            op_id: chosen by the page, unique.
            author: who does it.
            command: see :mod:`app.edits.commands`.
            expected: revision of each touched track as the page knows it (If-Match); unset: none was sent.

        Raises:
            NotFound: no such run.
            PreconditionRequired: a revision is missing.
            Conflict: a track has changed since (``details`` holds both versions), the video's frames are not known, or
                its file is another one by now (``file_changed``).
            Invalid: the command makes no sense, is about a frame that the video does not have, or names a label or an
                attribute that its label set does not have.
        """
        try:
            self._files.refuse(run_id)  # it may read the whole file: not while others wait to write
        except Conflict:
            if not self._is_stored(op_id):  # what was stored before the file changed is answered as ever
                raise
        reverting = isinstance(command, Undo | Redo)
        with self._database.write() as session:
            lock_for_edit(session, run_id, op_id, author, () if reverting else touched_keys(command))
            run = _require_run(session, run_id)
            known = session.scalars(select(Edit).where(Edit.op_id == op_id)).first()
            if known is not None:
                return self._again(session, known, run_id, author)
            edit: Edit | None = None
            if reverting:
                before, after, edit = self._revert(session, run, author, command)
            else:
                before, after = self._change(session, run, author, command, expected)
            row, saved = self._write(
                session,
                run,
                author,
                command.model_dump(mode="json"),
                before,
                after,
                command.frame if edit is None else edit.frame,
                op_id=op_id,
                reverts=None if edit is None else edit.op_id,
            )
            docs = list(saved.values())
            if edit is None:  # the newest operation is the next to undo, and nothing is left to redo
                own = Target(op_id=op_id, name=row.kind, frame=row.frame, keys=sorted(saved))
                return EditAnswer(seq=row.seq, docs=docs, undo=own, redo=None, op_id=op_id)
            undo, redo = self._targets(session, run, author)
            return EditAnswer(seq=row.seq, docs=docs, undo=undo, redo=redo, op_id=op_id)

    def _change(
        self, session: Session, run: Run, author: str, command: Any, expected: Mapping[str, int] | None
    ) -> tuple[dict[str, TrackDoc | None], dict[str, TrackDoc]]:
        """Documents before and after a command."""
        require_inside(command, known_frames(session, run))
        keys = touched_keys(command)
        present = self._present.load(session, run, keys)
        check_revisions(session, run.id, author, command, present, keys, expected)
        now = datetime.now(UTC).isoformat(timespec="seconds")
        labels = labels_of_run(session, run)
        command = by_key(command, labels)
        try:
            command = with_class(present, command, lambda track: self._evidence.label(run.id, track))
            after = apply_command(present, command, author, now)
        except CommandError as error:
            raise Invalid(str(error), field="command", code="impossible") from None
        require_known_labels(after.values(), labels)
        if isinstance(command, SetAttribute):
            engine = functools.partial(self._evidence.label, run.id)
            require_attribute(command, present[command.key], labels, engine)
        return {key: present.get(key) for key in after}, after

    def adopt(self, run_id: str, from_run: str, author: str) -> Adopted:
        """Carry the edits of another run of the same video over to this one; each is an operation of ``author``.

        Again later it brings what is new: tracks that nobody has touched since they came over follow the other run.

        Raises:
            NotFound: no such run.
            Invalid: the runs are of different videos, or the same.
            Conflict: this run is not complete, or the video's file is another one by now.
        """
        self._files.refuse(run_id)
        with self._database.read() as session:
            new, old = _require_run(session, run_id), _require_run(session, from_run)
            if new.id == old.id or new.video_id != old.video_id:
                raise Invalid("Edits go from one run to another run of the same video.", field="from_run")
            if new.state != "complete":
                raise Conflict(
                    "This run is not complete. Edits can be carried over once it is.", code="run_not_complete"
                )
        tracks = _engine_run(self._evidence.boxes(from_run)), _engine_run(self._evidence.boxes(run_id))
        with self._database.write() as session:
            lock_for_adoption(session, run_id)
            run = _require_run(session, run_id)
            present, docs = documents_of(session, run_id), documents_of(session, from_run)
            ours = adopted_keys(session, run_id, from_run, present)
            others = {k: doc for k, doc in present.items() if k not in ours}
            adoption = adopt_documents(docs, *tracks, others, known_frames(session, run))
            for key, documents in adoption.changed.items():
                if not all(name in present and present[name].same(doc) for name, doc in documents.items()):
                    before = {name: present.get(name) or self._present.fresh(run, name) for name in documents}
                    command = {"name": "adopt", "from_run": from_run, "key": key}
                    self._record(session, run, author, command, before, documents)
            return adopted(adoption)

    def put_documents(
        self,
        run_id: str,
        author: str,
        command: Mapping[str, Any],
        make: Callable[[Mapping[str, TrackDoc]], Mapping[str, TrackDoc]],
        begin: Callable[[Session], None] | None = None,
    ) -> tuple[int | None, list[str]]:
        """Change many tracks of a run in one operation, which one undo takes back.

        Args:
            run_id: the run.
            author: who does it.
            command: what the log says; ``name`` is the kind of operation.
            make: documents that are there now -> those to store. Called before the transaction that others wait for,
                and once more within it where somebody was faster.
            begin: what the transaction does first, once the run is locked.

        Returns:
            Number of the operation in the log, None if nothing changed; keys of the stored documents.

        Raises:
            NotFound: no such run.
            Conflict: the video's file is another one by now.
            Invalid: a document is about frames that the video does not have, or names a label that its set lacks.
        """
        self._files.refuse(run_id)
        with self._database.read() as session:
            seen = _newest(session, run_id)
            present = self._present.touched(session, _require_run(session, run_id))
        documents = dict(make(present))
        with self._database.write() as session:
            lock_for_adoption(session, run_id)
            run = _require_run(session, run_id)
            if begin is not None:
                begin(session)
            if _newest(session, run_id) != seen:
                present = self._present.touched(session, run)
                documents = dict(make(present))
            if not documents:
                return None, []
            before = {key: present.get(key) or self._present.fresh(run, key) for key in documents}
            row = self._record(session, run, author, command, before, documents)
            return row.seq, sorted(documents)

    def apply_to_tracks(
        self,
        run_id: str,
        op_id: str,
        author: str,
        name: str,
        make: Callable[[str], Sequence[Any]],
        expected: Mapping[str, int],
    ) -> TracksChanged:
        """Change many tracks of a run in one operation; those that cannot be changed stay as they are.

        The same ``op_id`` again gives the first answer again, without those that stayed.

        Args:
            run_id: the run.
            op_id: chosen by who asks, unique.
            author: who does it.
            name: of the kind of operation, for the log.
            make: key of a track -> the commands for it; see :mod:`app.edits.commands`.
            expected: revision of each track as the author knows it; they are changed in this order.

        Raises:
            NotFound: no such run.
            Conflict: the video's file is another one by now, or the ``op_id`` belongs to another run.
            Invalid: a command names a label that the video's set does not have.
        """
        try:
            self._files.refuse(run_id)
        except Conflict:
            if not self._is_stored(op_id):
                raise
        with self._database.write() as session:
            lock_for_many(session, run_id, op_id, author)
            run = _require_run(session, run_id)
            known = session.scalars(select(Edit).where(Edit.op_id == op_id)).first()
            if known is not None:
                self._again(session, known, run_id, author)
                return TracksChanged(sorted(known.after), {})
            present = self._present.load(session, run, list(expected))
            now = datetime.now(UTC).isoformat(timespec="seconds")
            after: dict[str, TrackDoc] = {}
            stayed: dict[str, str] = {}
            for key, revision in expected.items():
                doc = present.get(key)
                if doc is None or doc.gone:
                    stayed[key] = "it is not there any more"
                elif doc.revision != revision:
                    who = last_said(session, run_id, author, {key: revision}).get(key)
                    stayed[key] = "it was changed meanwhile" + (f" by {who.author}" if who else "")
                else:
                    try:
                        changed = _applied(doc, make(key), author, now)
                    except CommandError as error:
                        stayed[key] = str(error).rstrip(".")
                        continue
                    if not changed.same(doc):
                        after[key] = changed
            require_known_labels(after.values(), labels_of_run(session, run))
            if after:
                command = {"name": name, "commands": [each.model_dump(mode="json") for each in make(next(iter(after)))]}
                before = {key: present.get(key) for key in after}
                self._write(session, run, author, command, before, after, None, op_id=op_id)
            return TracksChanged(sorted(after), stayed)

    def record_first(
        self,
        session: Session,
        run: Run,
        author: str,
        command: Mapping[str, Any],
        documents: Mapping[str, tuple[TrackDoc | None, TrackDoc]],
        frame: int | None = None,
    ) -> int:
        """Begin the log of a run in the transaction that stores the run: nobody else can know it yet.

        Args:
            session: of that transaction.
            run: stored there already, complete.
            author: who brings it.
            command: what the log says; ``name`` is the kind of operation.
            documents: of each touched track, untouched (None: a person made it) and as it is now; by key.
            frame: where to look; None: the operation is about no frame.

        Returns:
            Number of the operation in the log; one undo takes it back.

        Raises:
            Invalid: a document is about frames that the video does not have.
        """
        before = {key: old for key, (old, _) in documents.items()}
        after = {key: new for key, (_, new) in documents.items()}
        return self._record(session, run, author, command, before, after, frame).seq

    def _record(
        self,
        session: Session,
        run: Run,
        author: str,
        command: Mapping[str, Any],
        before: Mapping[str, TrackDoc | None],
        documents: Mapping[str, TrackDoc],
        frame: int | None = None,
    ) -> Edit:
        """Save documents as one operation that no page has asked for by name."""
        require_documents_inside(documents.values(), known_frames(session, run))
        require_known_labels(documents.values(), labels_of_run(session, run))
        return self._write(session, run, author, dict(command), before, documents, frame, op_id=uuid4().hex)[0]

    def _write(
        self,
        session: Session,
        run: Run,
        author: str,
        command: dict[str, Any],
        before: Mapping[str, TrackDoc | None],
        after: Mapping[str, TrackDoc],
        frame: int | None,
        *,
        op_id: str,
        reverts: str | None = None,
    ) -> tuple[Edit, dict[str, TrackDoc]]:
        """Save documents, append the operation to the log and to the stream; the operation, and what it has left.

        The last thing in a transaction: once the number is drawn, others wait.
        """
        saved = self._present.save(session, run.id, before, after)
        row = Edit(
            op_id=op_id,
            run_id=run.id,
            author=author,
            kind=command["name"],
            command=command,
            frame=frame,
            before={key: None if doc is None else doc.model_dump(mode="json") for key, doc in before.items()},
            after={key: doc.model_dump(mode="json") for key, doc in saved.items()},
            reverts=reverts,
        )
        self._events.order(session)
        session.add(row)
        session.flush()
        docs = list(row.after.values()) if len(row.after) <= _MOST_REPORTED else None  # more than that, pages ask for
        reported = {"seq": row.seq, "op_id": op_id, "author": author, "docs": docs}
        self._events.publish(session, "edit", run.id, reported)
        return row, saved

    def _is_stored(self, op_id: str) -> bool:
        with self._database.read() as session:
            return session.scalars(select(Edit.seq).where(Edit.op_id == op_id)).first() is not None

    def _again(self, session: Session, edit: Edit, run_id: str, author: str) -> EditAnswer:
        if edit.run_id != run_id:
            raise Conflict("This op_id belongs to an operation on another run. Choose a fresh one.", code="op_id_used")
        docs = [TrackDoc.model_validate(doc) for doc in edit.after.values()]
        answer = self._annotated(session, run_id, author, docs)
        return EditAnswer(**{**answer.model_dump(), "op_id": edit.op_id})

    def _revert(
        self, session: Session, run: Run, author: str, command: Undo | Redo
    ) -> tuple[dict[str, TrackDoc | None], dict[str, TrackDoc], Edit]:
        """Documents before and after an undo or redo, and the operation that it is about."""
        # a page that has not heard of somebody else's change asks for what that bars; the answer tells it
        undo, redo = targets(session, run.id, author)
        if isinstance(command, Undo) and undo is not None and undo.op_id != command.op_id:
            undo = self._targets(session, run, author)[0]
        following = undo if isinstance(command, Undo) else redo
        if following is None or following.op_id != command.op_id:
            raise Conflict(
                f"That is not the operation to {command.name} next. Reload to see which is.", code="not_next"
            )
        edit = session.scalars(select(Edit).where(Edit.op_id == command.op_id)).one()
        start, goal = (edit.after, edit.before) if isinstance(command, Undo) else (edit.before, edit.after)
        lock_tracks(session, run.id, start)
        present = self._present.load(session, run, list(start))
        for key, expected in start.items():
            left = None if expected is None else self._present.closed(run, TrackDoc.model_validate(expected))
            if not _same(present.get(key), left):
                seen = {key: 0 if expected is None else int(expected["revision"])}
                others = last_said(session, run.id, author, seen).get(key)
                who = f"{others.author} has changed track {key}" if others else f"Track {key} has been changed"
                raise Conflict(
                    f"{who} since. {command.name.capitalize()} would lose that.",
                    code="stale",
                    details={
                        "current": [] if key not in present else [present[key].model_dump(mode="json")],
                        "yours": [] if goal[key] is None else [goal[key]],
                    },
                )
        after: dict[str, TrackDoc] = {}
        for key, wanted in goal.items():
            if wanted is None:  # there was no document: the engine's track, or of a person's nothing is left
                after[key] = self._present.fresh(run, key) or TrackDoc(key=key, gone=True)
            else:
                after[key] = TrackDoc.model_validate(wanted)
        return {key: present.get(key) for key in start}, after, edit

    def _targets(self, session: Session, run: Run, author: str) -> tuple[Target | None, Target | None]:
        """What the author can undo and redo next; what others have changed since cannot be undone."""

        def fits(left: Mapping[str, Any]) -> bool:
            present = self._present.load(session, run, list(left), change=False)
            return all(
                _same(present.get(key), self._present.closed(run, TrackDoc.model_validate(doc)))
                for key, doc in left.items()
            )

        return targets(session, run.id, author, fits)

    def _annotated(self, session: Session, run_id: str, author: str, docs: list[TrackDoc]) -> Annotation:
        undo, redo = self._targets(session, _require_run(session, run_id), author)
        seq = _newest(session, run_id)
        return Annotation(seq=seq, docs=docs, undo=undo, redo=redo)


def _applied(doc: TrackDoc, commands: Sequence[Any], author: str, now: str) -> TrackDoc:
    """A track after commands that are about it alone."""
    for command in commands:
        doc = apply_command({doc.key: doc}, command, author, now).get(doc.key, doc)
    return doc


def _engine_run(table: TrackTable) -> EngineRun:
    numbers = np.array([int(key[1:]) for key in table.names], np.int64)
    return EngineRun(table.frame, numbers[table.track] if len(table) else table.track, table.boxes, table.class_id)


def _newest(session: Session, run_id: str) -> int:
    """Number of the newest operation on a run; 0: none yet."""
    return session.scalar(select(func.max(Edit.seq)).where(Edit.run_id == run_id)) or 0


def _require_run(session: Session, run_id: str) -> Run:
    run = session.get(Run, run_id)
    if run is None:
        raise NotFound(f"There is no run {run_id[:40]!r}.")
    return run


def _same(present: TrackDoc | None, left: TrackDoc | None) -> bool:
    """Whether a track still is what an operation left behind, whatever its revision."""
    if left is None:
        return present is None or present.gone
    return present is not None and present.same(left)
