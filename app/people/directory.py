"""Finds the person of a secret or a name. Every request queries it, so a revocation takes effect at once."""

from __future__ import annotations

import threading
import time
from datetime import UTC, datetime, timedelta
from typing import Final, cast

from sqlalchemy import bindparam, delete, select
from sqlalchemy.exc import DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from sqlalchemy.orm import Session

from app.people.identity import Identity
from app.people.roles import Role
from app.people.secrets import hash_of, new_secret
from app.people.service import name_key
from app.storage.database import Database
from app.storage.models import Person, PersonSecret

SESSION_DAYS: Final = 30
"""Days that a browser stays signed in."""
_EMPTY_CACHE_S: Final = 1.0
"""Seconds that "the library has no people" is cached; another process may add the first person."""

_OWNER_OF: Final = (
    select(Person, PersonSecret)
    .join(PersonSecret, PersonSecret.person_id == Person.id)
    .where(PersonSecret.hash == bindparam("hash"), PersonSecret.kind == bindparam("kind"))
)


class Directory:
    """Looks people up."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._empty = True
        self._valid_until = 0.0
        self._generation = 0
        self._lock = threading.Lock()

    @property
    def is_known_empty(self) -> bool:
        """Whether the library had no people a moment ago, so that the database need not be queried."""
        return self._empty and time.monotonic() < self._valid_until

    @property
    def had_people(self) -> bool:
        """Whether the library had people at the last query; all may have been removed since."""
        return not self._empty

    def is_empty(self) -> bool:
        """Whether the library has no people.

        While the database is unavailable, the last answer holds: a library without people has nothing to protect.
        """
        if self.is_known_empty:
            return True
        with self._lock:
            before = self._generation
            try:
                with self._database.read_once() as session:
                    self._empty = session.scalars(select(Person.id).limit(1)).first() is None
            except (DBAPIError, PoolTimeout):
                if not self._empty or self._valid_until == 0.0:
                    raise
            # the answer may not include changes during the query
            self._valid_until = time.monotonic() + (_EMPTY_CACHE_S if before == self._generation else 0)
            return self._empty

    def invalidate(self) -> None:
        """Query again next time whether there are people."""
        self._generation += 1
        self._valid_until = min(self._valid_until, time.monotonic())

    def by_secret(self, secret: str, kind: str) -> tuple[Identity | None, bool]:
        """Return the person of a secret, and whether the secret was revoked.

        Args:
            secret: the secret in the request.
            kind: ``token`` or ``session``.
        """
        hashed = hash_of(secret)
        with self._database.read_once() as session:
            row = session.execute(_OWNER_OF, {"hash": hashed, "kind": kind}).first()
            if row is None:
                return None, False
            person, secret_row = row
            if secret_row.revoked is not None or (kind == "session" and secret_row.created < _oldest()):
                return None, True
            return _identity(person, hashed), False

    def by_name(self, name: str) -> Identity | None:
        """Return the person with a name; None: there is none."""
        with self._database.read_once() as session:
            person = session.scalars(select(Person).where(Person.key == name_key(name))).first()
            return None if person is None else _identity(person, None)

    def has_access(self, identity: Identity) -> bool:
        """Whether a signed-in caller still has access; unchanged while the database is unavailable."""
        try:
            return self._has_access(identity)
        except (DBAPIError, PoolTimeout):
            return True

    def _has_access(self, identity: Identity) -> bool:
        if identity.person is None:
            return not identity.owner or self.is_empty()
        with self._database.read_once() as session:
            if identity.credential is None:
                return session.get(Person, identity.person) is not None
            secret = session.get(PersonSecret, identity.credential)
            return secret is not None and secret.revoked is None

    def sign_in(self, token: str) -> tuple[Identity | None, str]:
        """Make a session for the owner of a token, and return its secret; None: the token is wrong or revoked."""
        identity, _ = self.by_secret(token, "token")
        if identity is None:
            return None, ""
        secret = new_secret()
        with self._database.write() as session:
            if not _in_use(session, hash_of(token)):  # revoked meanwhile
                return None, ""
            old = PersonSecret.kind == "session", PersonSecret.created < _oldest()
            session.execute(delete(PersonSecret).where(*old))
            session.add(PersonSecret(hash=hash_of(secret), person_id=identity.person, kind="session"))
        return identity, secret

    def is_session(self, identity: Identity) -> bool:
        """Whether the caller uses a browser's session, not a token or a proxy."""
        if identity.credential is None:
            return False
        with self._database.read_once() as session:
            secret_row = session.get(PersonSecret, identity.credential)
            return secret_row is not None and secret_row.kind == "session"

    def sign_out(self, identity: Identity) -> None:
        """End the session of a request; a token stays valid."""
        with self._database.write() as session:
            own_session = PersonSecret.hash == identity.credential, PersonSecret.kind == "session"
            session.execute(delete(PersonSecret).where(*own_session))


def _in_use(session: Session, hashed: str) -> bool:
    query = select(PersonSecret.hash).where(PersonSecret.hash == hashed, PersonSecret.revoked.is_(None))
    return session.scalars(query.with_for_update()).first() is not None


def _oldest() -> datetime:
    return datetime.now(UTC) - timedelta(days=SESSION_DAYS)


def _identity(person: Person, credential: str | None) -> Identity:
    return Identity(cast(Role, person.role), person.id, person.name, credential)
