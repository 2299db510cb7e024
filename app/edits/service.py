"""Edits of a run: checked, logged, applied and announced, all in one transaction."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from datetime import UTC, datetime

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.edits.apply import CommandError, apply_command, touched_keys, with_class, with_gaps
from app.edits.checks import (
    check_revisions,
    known_frames,
    require_attribute,
    require_inside,
    require_known_labels,
    resolve_label_key,
)
from app.edits.commands import Command, Redo, SetAttribute, Undo
from app.edits.documents import TrackDoc
from app.edits.log_store import LogStore, documents_of, lock_for_edit
from app.edits.undo import Target, UndoRedo
from app.edits.views import Annotation, EditAnswer, LogEntry, log_entry
from app.errors import Invalid
from app.labels.store import labels_of_run
from app.storage.lookup import newest_edit, require_run
from app.storage.models import Edit, Run


class EditService:
    """Edits of one person on one or a few tracks, and what can be undone."""

    def __init__(self, log: LogStore) -> None:
        self._log = log
        self._undo = UndoRedo(log)

    def annotation(self, run_id: str, author: str) -> Annotation:
        """All documents of a run, and what ``author`` can undo.

        Raises:
            NotFound: no such run.
        """
        with self._log.database.read() as session:
            undo, redo = self._undo.targets(session, require_run(session, run_id), author)
            docs = list(documents_of(session, run_id).values())
            return Annotation(seq=newest_edit(session, run_id), docs=docs, undo=undo, redo=redo)

    def log(self, run_id: str, after: int, limit: int = 1000) -> list[LogEntry]:
        """Rows of the log after a number.

        Raises:
            NotFound: no such run.
        """
        with self._log.database.read() as session:
            require_run(session, run_id)
            query = select(Edit).where(Edit.run_id == run_id, Edit.seq > after).order_by(Edit.seq).limit(limit)
            return [log_entry(edit) for edit in session.scalars(query)]

    def apply(
        self, run_id: str, op_id: str, author: str, command: Command | Undo | Redo, expected: Mapping[str, int] | None
    ) -> EditAnswer:
        """Apply one operation; a repeated ``op_id`` returns the first answer again.

        Args:
            run_id: the run.
            op_id: unique id, chosen by the page.
            author: author of the operation.
            command: see :mod:`app.edits.commands`.
            expected: revision of each touched track that the page knows (If-Match); unset: none was sent.

        Raises:
            NotFound: no such run.
            PreconditionRequired: a revision is missing.
            Conflict: a track has changed since (``details`` holds both versions), the video's frames are not known, or
                its file was replaced (``file_changed``).
            Invalid: the command is impossible, or names a frame that the video does not have, or a label or an
                attribute that its label set does not have.
        """
        self._log.require_unchanged_file(run_id, op_id)
        keys = [] if isinstance(command, Undo | Redo) else touched_keys(command)
        with self._log.database.write() as session:
            lock_for_edit(session, run_id, op_id, author, keys)
            run, stored = self._log.load_run(session, run_id, op_id)
            if stored is not None:
                docs = [TrackDoc.model_validate(doc) for doc in stored.after.values()]
                return self._answer(session, run, author, docs, op_id)
            command_json, reverted = command.model_dump(mode="json"), None
            if isinstance(command, Undo | Redo):
                before, after, edit = self._undo.documents(session, run, author, command)
                frame, reverted = edit.frame, edit.op_id
            else:
                before, after = self._change(session, run, author, command, expected)
                frame = command.frame
            row, saved = self._log.append(
                session, run, author, command_json, before, after, frame, op_id=op_id, reverts=reverted
            )
            docs = list(saved.values())
            if reverted is not None:
                return self._answer(session, run, author, docs, op_id)
            # the newest operation is the next to undo, and nothing is left to redo
            undo_target = Target(op_id=op_id, name=row.kind, frame=row.frame, keys=sorted(saved))
            return EditAnswer(seq=row.seq, docs=docs, undo=undo_target, redo=None, op_id=op_id)

    def _change(
        self, session: Session, run: Run, author: str, command: Command, expected: Mapping[str, int] | None
    ) -> tuple[dict[str, TrackDoc | None], dict[str, TrackDoc]]:
        """Documents before and after a command."""
        require_inside(command, known_frames(session, run))
        keys = touched_keys(command)
        present = self._log.load(session, run, keys)
        check_revisions(session, run.id, author, command, present, keys, expected)
        now = datetime.now(UTC).isoformat(timespec="seconds")
        labels = labels_of_run(session, run)
        command = resolve_label_key(command, labels)
        try:
            command = with_class(present, command, lambda track: self._log.evidence.label(run.id, track))
            command = with_gaps(present, command, lambda track: self._log.evidence.gaps(run.id, track))
            after = apply_command(present, command, author, now)
        except CommandError as error:
            raise Invalid(str(error), field="command", code="impossible") from None
        require_known_labels(after.values(), labels)
        if isinstance(command, SetAttribute):
            engine = functools.partial(self._log.evidence.label, run.id)
            require_attribute(command, present[command.key], labels, engine)
        return {key: present.get(key) for key in after}, after

    def _answer(self, session: Session, run: Run, author: str, docs: list[TrackDoc], op_id: str) -> EditAnswer:
        undo, redo = self._undo.targets(session, run, author)
        return EditAnswer(seq=newest_edit(session, run.id), docs=docs, undo=undo, redo=redo, op_id=op_id)
