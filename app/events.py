"""Events for pages: a numbered stream in the database, so workers, servers and pages share one order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from sqlalchemy import delete, func, insert, select, text
from sqlalchemy.orm import Session

from app.storage.models import Event
from tsr_engine.json_shapes import JsonObject

_ORDER_KEY = "events ordered"
_ORDER_LOCK = text("SELECT pg_advisory_xact_lock(7461)")
_APPEND = insert(Event)
"""The table, for plain rows without objects."""


class EventBus:
    """Appends to the stream of events and reads it from a number on."""

    max_events = 20_000
    """Events that are kept; a page that is further behind reloads everything."""

    def order(self, session: Session) -> None:
        """Wait for the turn of this writer, so that numbers become visible in order (SQLite orders writers anyway)."""
        if not session.info.get(_ORDER_KEY) and session.get_bind().dialect.name == "postgresql":
            session.connection().execute(_ORDER_LOCK)
            session.info[_ORDER_KEY] = True  # sessions of app.storage.database last for one transaction

    def publish(self, session: Session, kind: str, subject: str, data: JsonObject) -> None:
        """Append an event in the caller's transaction, so that pages see it only if the transaction commits."""
        self.publish_all(session, kind, {subject: data})

    def publish_all(self, session: Session, kind: str, data: Mapping[str, JsonObject]) -> None:
        """Like :meth:`publish` for many subjects, in one statement.

        Args:
            session: writes.
            kind: of the events.
            data: by subject, in the order of the events; at least one.
        """
        self.order(session)
        rows = [{"kind": kind, "subject": subject, "data": fields} for subject, fields in data.items()]
        session.connection().execute(_APPEND, rows)

    def newest(self, session: Session) -> int:
        """Number of the newest event; 0: none yet."""
        return session.scalar(select(func.max(Event.seq))) or 0

    def oldest(self, session: Session) -> int:
        """Number of the oldest stored event; 0: none yet."""
        return session.scalar(select(func.min(Event.seq))) or 0

    def after(self, session: Session, seq: int, limit: int = 500) -> Sequence[Event]:
        """Events after a number, in order."""
        return session.scalars(select(Event).where(Event.seq > seq).order_by(Event.seq).limit(limit)).all()

    def prune(self, session: Session) -> None:
        """Delete all but the newest ``max_events`` events."""
        session.execute(delete(Event).where(Event.seq <= self.newest(session) - self.max_events))
