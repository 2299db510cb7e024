"""Operations on many tracks at once; each is one row of the log and one undo."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from uuid import uuid4

import numpy as np
from sqlalchemy.orm import Session

from app.edits.adopt import EngineRun, adopt_documents
from app.edits.apply import CommandError, apply_command
from app.edits.checks import known_frames, require_documents_inside, require_known_labels
from app.edits.commands import Command
from app.edits.documents import TrackDoc
from app.edits.history import adopted_keys, last_operations
from app.edits.log_store import LogStore, documents_of, lock_for_many, lock_run
from app.edits.views import Adopted, adopted
from app.errors import Conflict, Invalid
from app.labels.store import labels_of_run
from app.storage.lookup import newest_edit, require_run
from app.storage.models import Edit, Run
from tsr_engine.track_table import TrackTable


@dataclass(frozen=True, slots=True)
class TracksChanged:
    """Result of an operation on many tracks.

    Attributes:
        changed: keys of the changed tracks; empty: nothing was stored.
        stayed: key -> reason, as the end of a sentence without its full stop.
    """

    changed: list[str]
    stayed: dict[str, str]


class BulkEdits:
    """Changes many tracks of a run in one operation."""

    def __init__(self, log: LogStore) -> None:
        self._log = log

    def adopt(self, run_id: str, from_run: str, author: str) -> Adopted:
        """Carry the edits of another run of the same video over to this one; each is an operation of ``author``.

        A repeated call carries over what is new: tracks that nobody has changed since the last call follow the other
        run.

        Raises:
            NotFound: no such run.
            Invalid: the runs are of different videos, or the same.
            Conflict: this run is not complete, or the video's file was replaced.
        """
        self._log.require_unchanged_file(run_id)
        with self._log.database.read() as session:
            new, old = require_run(session, run_id), require_run(session, from_run)
            if new.id == old.id or new.video_id != old.video_id:
                raise Invalid("Edits go from one run to another run of the same video.", field="from_run")
            if new.state != "complete":
                raise Conflict("This run is not complete. Carry edits over when it is.", code="run_not_complete")
        tracks = _engine_run(self._log.evidence.boxes(from_run)), _engine_run(self._log.evidence.boxes(run_id))
        with self._log.database.write() as session:
            lock_run(session, run_id)
            run = require_run(session, run_id)
            present, docs = documents_of(session, run_id), documents_of(session, from_run)
            adopted_names = adopted_keys(session, run_id, from_run, present)
            others = {k: doc for k, doc in present.items() if k not in adopted_names}
            adoption = adopt_documents(docs, *tracks, others, known_frames(session, run))
            for key, documents in adoption.changed.items():
                if not all(name in present and present[name].has_same_content(doc) for name, doc in documents.items()):
                    before = {name: present.get(name) or self._log.untouched_document(run, name) for name in documents}
                    command = {"name": "adopt", "from_run": from_run, "key": key}
                    self.record(session, run, author, command, before, documents)
            return adopted(adoption)

    def put_documents(
        self,
        run_id: str,
        author: str,
        command: Mapping[str, object],
        make: Callable[[Mapping[str, TrackDoc]], Mapping[str, TrackDoc]],
        begin: Callable[[Session], None] | None = None,
    ) -> int | None:
        """Change many tracks of a run in one operation, which one undo reverts.

        Args:
            run_id: the run.
            author: author of the operation.
            command: the command to log; ``name`` is the kind of operation.
            make: maps the current documents to those to store. It is called before the transaction, because others wait
                for that, and again in the transaction if the documents have changed.
            begin: called first in the transaction, after the run is locked.

        Returns:
            Number of the operation in the log; None: nothing has changed.

        Raises:
            NotFound: no such run.
            Conflict: the video's file was replaced.
            Invalid: a document names frames that the video does not have, or a label that its set lacks.
        """
        self._log.require_unchanged_file(run_id)
        with self._log.database.read() as session:
            newest = newest_edit(session, run_id)
            present = self._log.edited_documents(session, require_run(session, run_id))
        documents = dict(make(present))
        with self._log.database.write() as session:
            lock_run(session, run_id)
            run = require_run(session, run_id)
            if begin is not None:
                begin(session)
            if newest_edit(session, run_id) != newest:
                present = self._log.edited_documents(session, run)
                documents = dict(make(present))
            if not documents:
                return None
            before = {key: present.get(key) or self._log.untouched_document(run, key) for key in documents}
            return self.record(session, run, author, command, before, documents).seq

    def apply_to_tracks(
        self,
        run_id: str,
        op_id: str,
        author: str,
        name: str,
        make: Callable[[str], Sequence[Command]],
        expected: Mapping[str, int],
    ) -> TracksChanged:
        """Change many tracks of a run in one operation; tracks that cannot be changed stay as they are.

        A repeated ``op_id`` returns the first answer again, without the tracks that stayed.

        Args:
            run_id: the run.
            op_id: unique id, chosen by the caller.
            author: author of the operation.
            name: kind of operation, for the log.
            make: maps the key of a track to its commands; see :mod:`app.edits.commands`.
            expected: revision of each track that the author saw; tracks are changed in this order.

        Raises:
            NotFound: no such run.
            Conflict: the video's file was replaced, or the ``op_id`` belongs to another run.
            Invalid: a command names a label that the video's set does not have.
        """
        self._log.require_unchanged_file(run_id, op_id)
        with self._log.database.write() as session:
            lock_for_many(session, run_id, op_id, author)
            run, known = self._log.load_run(session, run_id, op_id)
            if known is not None:
                return TracksChanged(sorted(known.after), {})
            present = self._log.load(session, run, list(expected))
            now = datetime.now(UTC).isoformat(timespec="seconds")
            after: dict[str, TrackDoc] = {}
            stayed: dict[str, str] = {}
            for key, revision in expected.items():
                doc = present.get(key)
                if doc is None or doc.gone:
                    stayed[key] = "it no longer exists"
                elif doc.revision != revision:
                    who = last_operations(session, run_id, author, {key: revision}).get(key)
                    stayed[key] = "it was changed meanwhile" + (f" by {who.author}" if who else "")
                else:
                    try:
                        changed = _apply_all(doc, make(key), author, now)
                    except CommandError as error:
                        stayed[key] = str(error).rstrip(".")
                        continue
                    if not changed.has_same_content(doc):
                        after[key] = changed
            require_known_labels(after.values(), labels_of_run(session, run))
            if after:
                command = {"name": name, "commands": [each.model_dump(mode="json") for each in make(next(iter(after)))]}
                before = {key: present.get(key) for key in after}
                self._log.append(session, run, author, command, before, after, None, op_id=op_id)
            return TracksChanged(sorted(after), stayed)

    def record(
        self,
        session: Session,
        run: Run,
        author: str,
        command: Mapping[str, object],
        before: Mapping[str, TrackDoc | None],
        documents: Mapping[str, TrackDoc],
        frame: int | None = None,
    ) -> Edit:
        """Store documents as one operation without an ``op_id`` of a page.

        Args:
            session: of the transaction, which has locked the run or stores it too.
            run: already in the session.
            author: author of the operation.
            command: the command to log; ``name`` is the kind of operation.
            before: documents before, by key; None: there was none.
            documents: documents after, by key.
            frame: frame to show for the operation; None: it has none.

        Raises:
            Invalid: a document names frames that the video does not have, or a label that its set lacks.
        """
        require_documents_inside(documents.values(), known_frames(session, run))
        require_known_labels(documents.values(), labels_of_run(session, run))
        return self._log.append(session, run, author, command, before, documents, frame, op_id=uuid4().hex)[0]


def _apply_all(doc: TrackDoc, commands: Sequence[Command], author: str, now: str) -> TrackDoc:
    """Apply commands that touch one track only."""
    for command in commands:
        doc = apply_command({doc.key: doc}, command, author, now).get(doc.key, doc)
    return doc


def _engine_run(table: TrackTable) -> EngineRun:
    numbers = np.array([int(key[1:]) for key in table.names], np.int64)
    return EngineRun(table.frame, numbers[table.track] if len(table) else table.track, table.boxes, table.class_id)
