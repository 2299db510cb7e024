"""Sums over documents and log, kept in the transaction of each edit: reviewed tracks, verdicts, hours of work.

Rows of the log count in their order. Clocks of servers can differ, so a step back in time counts as no work. Writers
hold the order of events meanwhile, so that two of them never change one sum at a time.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any, Final

from sqlalchemy import bindparam, delete, func, insert, select, update
from sqlalchemy.orm import Session

from app.edits.history import undone_operations
from app.storage.lookup import in_parts
from app.storage.models import Edit, ReviewCount, Verdict, WorkDay
from tsr_engine.json_shapes import JsonMapping

_MAX_PAUSE: Final = timedelta(minutes=5)
"""Longest pause between two operations that counts as work; of a longer pause only this much counts."""
_VERDICTS: Final = ("accepted", "rejected")
_REVERTING_KINDS: Final = ("undo", "redo")
_REVIEWING_KINDS: Final = ("set_review", "review_tracks")
_MANY_TRACKS_KIND: Final = "edit_tracks"
"""Kind of operation that holds the commands for its first track."""

_LATEST = select(func.max(WorkDay.latest))
_LAST_DAY = (
    select(WorkDay, _LATEST.scalar_subquery())
    .where(WorkDay.author == bindparam("author"))
    .order_by(WorkDay.seq.desc(), WorkDay.last.desc())
    .limit(1)
)

Change = tuple[str, JsonMapping | None, JsonMapping]
"""Key of a track, its document before (None: there was none), and after."""


def count_reviewed(session: Session, run_id: str, changes: Iterable[Change]) -> None:
    """Update the sums of a run for changed documents.

    Args:
        session: writes; holds the order of events.
        run_id: the run.
        changes: the changed documents.
    """
    more = reviewed = 0
    for key, before, after in changes:
        (existed, was_reviewed), (exists, is_reviewed) = _counts_of(key, before), _counts_of(key, after)
        more, reviewed = more + exists - existed, reviewed + is_reviewed - was_reviewed
    if more or reviewed:
        count = session.get(ReviewCount, run_id)
        if count is None:
            count = ReviewCount(run_id=run_id, more=0, reviewed=0)
            session.add(count)
        count.more, count.reviewed = count.more + more, count.reviewed + reviewed


def _counts_of(key: str, document: JsonMapping | None) -> tuple[int, int]:
    """Tracks that a document adds to the engine's, and reviewed tracks."""
    if document is None:
        return 0, 0
    is_deleted = bool(document.get("gone"))
    more = -int(is_deleted) if key.startswith("m") else int(not is_deleted)
    return more, int(not is_deleted and document.get("review") in _VERDICTS)


def add_to_totals(session: Session, edit: Edit) -> None:
    """Add a new operation to the work of its author.

    Args:
        session: writes; holds the order of events.
        edit: the newest row of the log.
    """
    _add_work(session, edit)
    if edit.kind in _REVERTING_KINDS:
        reverted = session.scalars(select(Edit).where(Edit.op_id == edit.reverts)).first()
        if reverted is not None and _verdict_of(reverted.kind, reverted.command) is not None:
            keys = list(reverted.after)
            _replace(session, edit, keys, _current_verdicts(session, edit.run_id, edit.author, keys))
        return
    verdict = _verdict_of(edit.kind, edit.command)
    if verdict in _VERDICTS:
        _replace(session, edit, list(edit.after), dict.fromkeys(edit.after, (verdict, day_of(edit.created))))


def day_of(moment: datetime) -> int:
    """Days since 1970 UTC."""
    return (moment.astimezone(UTC).date() - datetime(1970, 1, 1, tzinfo=UTC).date()).days


def _work_between(earlier: datetime | None, later: datetime) -> float:
    """Seconds of work between two successive operations of a person in the log."""
    return 0.0 if earlier is None else min(max(later - earlier, timedelta()), _MAX_PAUSE).total_seconds()


def _add_work(session: Session, edit: Edit) -> None:
    found = session.execute(_LAST_DAY, {"author": edit.author}).first()
    if found is not None and found[0].seq >= edit.seq:
        # SQLite gives the numbers of a removed run's edits again: the days that have them come before this edit
        reused = WorkDay.author == edit.author, WorkDay.seq >= edit.seq
        session.execute(update(WorkDay).where(*reused).values(seq=edit.seq - 1))
        found = session.execute(_LAST_DAY, {"author": edit.author}).first()
    before, latest = (None, session.scalar(_LATEST)) if found is None else found
    seconds = _work_between(None if before is None else before.last, edit.created)
    back = 0.0 if latest is None else max(0.0, (latest - edit.created).total_seconds())
    number = day_of(edit.created)
    day = before if before is not None and before.day == number else session.get(WorkDay, (edit.author, number))
    if day is None:
        day = WorkDay(author=edit.author, day=number, seconds=0.0, back=0.0, latest=edit.created)
        session.add(day)
    day.seconds, day.back = day.seconds + seconds, max(day.back, back)
    day.seq, day.last, day.latest = edit.seq, edit.created, max(day.latest, edit.created)


def _verdict_of(kind: str, command: JsonMapping) -> str | None:
    """The verdict that an operation gives; None: it gives none."""
    commands = command["commands"] if kind == _MANY_TRACKS_KIND else [command]
    return next((str(each["review"]) for each in commands if each["name"] in _REVIEWING_KINDS), None)


def _last_verdicts(edits: Sequence[Any]) -> dict[str, tuple[str, int]]:  # Any: rows have no types
    """Key of a track -> the last verdict that was not undone, and its day.

    Args:
        edits: of one person on one run, in the order of the log: rows with op_id, kind, command, reverts, created and
            ``after``, whose keys are their tracks.
    """
    undone = undone_operations((row.kind, row.reverts) for row in edits)
    found: dict[str, tuple[str, int]] = {}
    for row in edits:
        verdict = None if row.kind in _REVERTING_KINDS else _verdict_of(row.kind, row.command)
        if verdict in _VERDICTS and row.op_id not in undone:
            assert verdict is not None
            found |= dict.fromkeys(row.after, (verdict, day_of(row.created)))
    return found


def _current_verdicts(session: Session, run_id: str, author: str, keys: Sequence[str]) -> dict[str, tuple[str, int]]:
    """A person's current verdicts on tracks according to the log."""
    kinds = [*_REVERTING_KINDS, *_REVIEWING_KINDS, _MANY_TRACKS_KIND]
    by_author = Edit.run_id == run_id, Edit.author == author, Edit.kind.in_(kinds)
    query = select(Edit.op_id, Edit.kind, Edit.command, Edit.reverts, Edit.created, Edit.after).where(*by_author)
    found = _last_verdicts(session.execute(query.order_by(Edit.seq)).all())
    return {key: found[key] for key in keys if key in found}


def _replace(session: Session, edit: Edit, keys: Sequence[str], found: Mapping[str, tuple[str, int]]) -> None:
    owner = {"run_id": edit.run_id, "author": edit.author}
    for part in in_parts(keys):
        old = Verdict.run_id == edit.run_id, Verdict.author == edit.author, Verdict.key.in_(part)
        session.execute(delete(Verdict).where(*old))
    rows = [owner | {"key": key, "verdict": verdict, "day": day} for key, (verdict, day) in found.items()]
    if rows:
        session.execute(insert(Verdict), rows)
