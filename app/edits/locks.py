"""Edits that could disturb each other wait for each other; all others go on side by side.

SQLite has one writer at a time anyway. PostgreSQL's advisory locks are always taken in the order of this module, and
before the lock on the order of events, so that nobody waits in a circle.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

from sqlalchemy import text
from sqlalchemy.orm import Session

__all__ = ["lock_for_adoption", "lock_for_edit", "lock_for_many", "lock_tracks"]


def lock_for_edit(session: Session, run_id: str, op_id: str, author: str, keys: Iterable[str] = ()) -> None:
    """One edit: nothing else with this operation, by this author, or on these tracks of the run goes on meanwhile."""
    whole = [f"op {op_id}", f"author {run_id} {author}"]
    _take(session, whole, shared=[f"run {run_id}"], then=[f"track {run_id} {key}" for key in sorted(keys)])


def lock_tracks(session: Session, run_id: str, keys: Iterable[str]) -> None:
    """Tracks that became known only after :func:`lock_for_edit`, which had none."""
    _take(session, [f"track {run_id} {key}" for key in sorted(keys)])


def lock_for_many(session: Session, run_id: str, op_id: str, author: str) -> None:
    """One edit of many tracks: nothing else goes on in the run meanwhile, nor with this operation or by this author."""
    _take(session, [f"op {op_id}", f"author {run_id} {author}", f"run {run_id}"])


def lock_for_adoption(session: Session, run_id: str) -> None:
    """All tracks of a run."""
    _take(session, [f"run {run_id}"])


def _take(session: Session, names: list[str], shared: Iterable[str] = (), then: Iterable[str] = ()) -> None:
    if session.get_bind().dialect.name != "postgresql":
        return
    calls = [
        *(f"pg_advisory_xact_lock({_number(name)})" for name in names),
        *(f"pg_advisory_xact_lock_shared({_number(name)})" for name in shared),
        *(f"pg_advisory_xact_lock({_number(name)})" for name in then),
    ]
    if calls:
        session.execute(text(f"SELECT {', '.join(calls)}"))


def _number(name: str) -> int:
    """63 bits of a name; two names of one number only wait for each other without need."""
    return int.from_bytes(hashlib.blake2b(name.encode(), digest_size=8).digest(), "big") >> 1
