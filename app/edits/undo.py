"""Undo and redo, derived from the log, so a reload loses nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.body_model import Model
from app.edits.commands import Redo, Undo
from app.edits.documents import TrackDoc
from app.edits.history import last_operations
from app.edits.log_store import LogStore, lock_tracks
from app.errors import Conflict
from app.storage.models import Edit, Run

_FIRST_PAGE = 8
_MAX_SKIPPED = 100
"""Maximum number of operations to skip because others have changed their tracks since."""


class Target(Model):
    """The operation that Ctrl+Z or Ctrl+Shift+Z applies to."""

    op_id: str
    name: str
    frame: int | None
    keys: list[str]


class UndoRedo:
    """Finds what an author can undo and redo next, and the documents that result."""

    def __init__(self, log: LogStore) -> None:
        self._log = log

    def targets(self, session: Session, run: Run, author: str) -> tuple[Target | None, Target | None]:
        """The next operations to undo and to redo; those whose tracks others have changed since cannot be undone."""

        def is_unchanged(left: Mapping[str, object]) -> bool:
            present = self._log.load(session, run, list(left), change=False)
            return all(
                _is_unchanged(present.get(key), self._log.close_segments(run, TrackDoc.model_validate(doc)))
                for key, doc in left.items()
            )

        return targets(session, run.id, author, is_unchanged)

    def documents(
        self, session: Session, run: Run, author: str, command: Undo | Redo
    ) -> tuple[dict[str, TrackDoc | None], dict[str, TrackDoc], Edit]:
        """Documents before and after an undo or redo, and the operation that it reverts.

        Raises:
            Conflict: it is not the next one, or a track has changed since.
        """
        # a page that does not know another person's change may request a blocked operation
        undo, redo = targets(session, run.id, author)
        if isinstance(command, Undo) and undo is not None and undo.op_id != command.op_id:
            undo = self.targets(session, run, author)[0]
        next_operation = undo if isinstance(command, Undo) else redo
        if next_operation is None or next_operation.op_id != command.op_id:
            raise Conflict(
                f"That is not the operation to {command.name} next. Reload to see which is.", code="not_next"
            )
        edit = session.scalars(select(Edit).where(Edit.op_id == command.op_id)).one()
        start, goal = (edit.after, edit.before) if isinstance(command, Undo) else (edit.before, edit.after)
        lock_tracks(session, run.id, start)
        present = self._log.load(session, run, list(start))
        for key, expected in start.items():
            expected_document = (
                None if expected is None else self._log.close_segments(run, TrackDoc.model_validate(expected))
            )
            if not _is_unchanged(present.get(key), expected_document):
                seen = {key: 0 if expected is None else int(expected["revision"])}
                others = last_operations(session, run.id, author, seen).get(key)
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
            if wanted is None:  # there was no document: restore the engine's track, or delete a person's
                after[key] = self._log.untouched_document(run, key) or TrackDoc(key=key, gone=True)
            else:
                after[key] = TrackDoc.model_validate(wanted)
        return {key: present.get(key) for key in start}, after, edit


def targets(
    session: Session, run_id: str, author: str, is_unchanged: Callable[[Mapping[str, object]], bool] | None = None
) -> tuple[Target | None, Target | None]:
    """Find what ``author`` can undo and redo next.

    Operations are undone from the newest on and redone in the opposite order, and a new operation discards those that
    could be redone. So the next to undo is the newest that is not undone, and the next to redo is the last undone one
    since the newest operation. The log is read backwards, only as far as needed.

    Args:
        session: reads the log.
        run_id: the run.
        author: the author.
        is_unchanged: whether tracks are still as an operation left them (key -> document). Other operations are
            skipped, at most ``_MAX_SKIPPED`` of them, so that a change by another person does not block all earlier
            ones. Unset: none is skipped.
    """
    undoable: str | None = None
    last_revert: dict[str, str] = {}
    reverts_since: list[tuple[str, str]] = []
    only_reverts = True
    skipped = 0
    for op_id, kind, reverted in _backwards(session, run_id, author):
        if reverted is not None:
            last_revert.setdefault(reverted, kind)
            if only_reverts:
                reverts_since.append((kind, reverted))
        else:
            only_reverts = False
            if last_revert.get(op_id) == "undo":
                continue
            if is_unchanged is None or is_unchanged(
                session.scalars(select(Edit.after).where(Edit.op_id == op_id)).one()
            ):
                undoable = op_id
                break
            skipped += 1
            if skipped > _MAX_SKIPPED:
                break
    undone: list[str] = []
    for kind, reverted in reversed(reverts_since):
        if kind == "undo":
            undone.append(reverted)
        else:
            undone.remove(reverted)
    return _target(session, undoable), _target(session, undone[-1] if undone else None)


def _backwards(session: Session, run_id: str, author: str) -> Iterator[tuple[str, str, str | None]]:
    """Operation, kind and reverted operation: the author's log from the newest row on, page by page."""
    query = (
        select(Edit.seq, Edit.op_id, Edit.kind, Edit.reverts)
        .where(Edit.run_id == run_id, Edit.author == author)
        .order_by(Edit.seq.desc())
    )
    size, before = _FIRST_PAGE, None
    while True:
        page = session.execute((query if before is None else query.where(Edit.seq < before)).limit(size)).all()
        for seq, op_id, kind, reverts in page:
            before = seq
            yield op_id, kind, reverts
        if len(page) < size:
            return
        size *= 4


def _target(session: Session, op_id: str | None) -> Target | None:
    if op_id is None:
        return None
    columns = select(Edit.kind, Edit.frame, Edit.after).where(Edit.op_id == op_id)
    kind, frame, after = session.execute(columns).one()
    return Target(op_id=op_id, name=kind, frame=frame, keys=sorted(after))


def _is_unchanged(present: TrackDoc | None, left: TrackDoc | None) -> bool:
    """Whether a track is still what an operation left, apart from its revision."""
    if left is None:
        return present is None or present.gone
    return present is not None and present.has_same_content(left)
