"""Accounts: add and remove people, set roles, create and revoke tokens."""

from __future__ import annotations

import unicodedata
from datetime import UTC, datetime
from uuid import uuid4

from sqlalchemy import func, select, update
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from app.body_model import Model
from app.errors import Conflict, Invalid, NotFound
from app.events import EventBus
from app.people.roles import Role
from app.people.secrets import hash_of, new_secret
from app.storage.database import Database
from app.storage.models import Assignment, Person, PersonSecret

_MAX_NAME_LENGTH = 80
_MAX_NOTE_LENGTH = 200
_ID_DIGITS = 8
"""Number of digits of a token's hash that identify it in lists."""


class TokenView(Model):
    """A valid token; the secret itself is stored nowhere."""

    id: str
    note: str
    created: str


class PersonView(Model):
    """An account."""

    name: str
    role: Role
    created: str
    assignments: int
    """Number of assignments that are not done."""


class PeopleService:
    """Accounts of a library."""

    def __init__(self, database: Database, events: EventBus) -> None:
        self._database = database
        self._events = events

    def views(self) -> list[PersonView]:
        """All people by name."""
        with self._database.read() as session:
            rows = session.scalars(select(Person).order_by(Person.key)).all()
            open_ones = (
                select(Assignment.person_id, func.count())
                .where(Assignment.state != "done")
                .group_by(Assignment.person_id)
            )
            open_counts = {person: count for person, count in session.execute(open_ones)}  # noqa: C416 - a Row is no tuple
            return [_view(row, open_counts.get(row.id, 0)) for row in rows]

    def tokens(self, name: str) -> list[TokenView]:
        """Valid tokens of a person, oldest first.

        Raises:
            NotFound: no such person.
        """
        with self._database.read() as session:
            person = person_named(session, name)
            valid_tokens = (
                PersonSecret.person_id == person.id,
                PersonSecret.kind == "token",
                PersonSecret.revoked.is_(None),
            )
            rows = session.scalars(select(PersonSecret).where(*valid_tokens).order_by(PersonSecret.created))
            return [
                TokenView(id=row.hash[:_ID_DIGITS], note=row.note, created=row.created.isoformat(timespec="seconds"))
                for row in rows
            ]

    def add(self, name: str, role: Role) -> tuple[PersonView, str]:
        """Add a person; return the account and its first token, which cannot be shown again.

        Raises:
            Invalid: the name is not allowed.
            Conflict: the name is taken.
        """
        name = _check_name(name)
        secret = new_secret()
        person = Person(id=uuid4().hex, name=name, key=name_key(name), role=role)
        try:
            with self._database.write() as session:
                session.add(person)
                session.flush()
                session.add(PersonSecret(hash=hash_of(secret), person_id=person.id, kind="token", note="first token"))
                self._publish(session)
        except IntegrityError:
            raise Conflict(f"There is a person {name!r} already. Choose another name.", code="name_taken") from None
        return _view(person, 0), secret

    def remove(self, name: str) -> None:
        """Remove an account with its tokens, sessions and assignments; the person's changes keep the name.

        Raises:
            NotFound: no such person.
            Conflict: the person is the last administrator, and others remain.
        """
        with self._database.write() as session:
            person = person_named(session, name)
            if person.role == "admin":
                self._keep_admin(session, person, "remove")
            session.delete(person)
            self._publish(session)

    def set_role(self, name: str, role: Role) -> PersonView:
        """Change the role of a person, effective with the next request.

        Raises:
            NotFound: no such person.
            Conflict: the person is the last administrator, and others remain.
        """
        with self._database.write() as session:
            person = person_named(session, name)
            if person.role == "admin" and role != "admin":
                self._keep_admin(session, person, "change")
            person.role = role
            self._publish(session)
            return _view(person, 0)

    def new_token(self, name: str, note: str = "") -> str:
        """Make another token for a person, for example for a script; it cannot be shown again.

        Raises:
            NotFound: no such person.
            Invalid: the note is too long.
        """
        if len(note) > _MAX_NOTE_LENGTH or "\x00" in note:
            raise Invalid(f"The note of a token has at most {_MAX_NOTE_LENGTH} characters.", field="note")
        secret = new_secret()
        with self._database.write() as session:
            person = person_named(session, name)
            session.add(PersonSecret(hash=hash_of(secret), person_id=person.id, kind="token", note=note))
        return secret

    def rotate(self, name: str) -> str:
        """Revoke all tokens and sessions of a person, and make a new token, which cannot be shown again.

        Raises:
            NotFound: no such person.
        """
        secret = new_secret()
        with self._database.write() as session:
            person = person_named(session, name)
            self._revoke(session, person)
            session.add(PersonSecret(hash=hash_of(secret), person_id=person.id, kind="token", note="rotated"))
            self._publish(session)
        return secret

    def revoke(self, name: str, token: str | None = None) -> int:
        """Revoke tokens of a person, and all sessions; open pages are signed out at once.

        Sessions do not record their token, so all end with any token.

        Args:
            name: name of the person.
            token: id of one token, as in the list; None: all of them.

        Returns:
            Number of revoked tokens.

        Raises:
            NotFound: no such person, or no such valid token.
        """
        with self._database.write() as session:
            person = person_named(session, name)
            count = self._revoke(session, person, token)
            if token is not None and count == 0:
                raise NotFound(f"{person.name!r} has no token {token[:80]!r} in use. 'tsr people list' shows them.")
            self._publish(session)
        return count

    def _revoke(self, session: Session, person: Person, token: str | None = None) -> int:
        in_use = PersonSecret.person_id == person.id, PersonSecret.revoked.is_(None)
        revoked = update(PersonSecret).values(revoked=datetime.now(UTC))
        which = [*in_use, PersonSecret.kind == "token"]
        if token is not None:
            which.append(func.substr(PersonSecret.hash, 1, _ID_DIGITS) == token)
        hashes = session.scalars(select(PersonSecret.hash).where(*which)).all()
        session.execute(revoked.where(PersonSecret.hash.in_(hashes)))
        if token is None or hashes:
            session.execute(revoked.where(*in_use, PersonSecret.kind == "session"))
        return len(hashes)

    def _keep_admin(self, session: Session, person: Person, what: str) -> None:
        others = select(func.count()).select_from(Person).where(Person.id != person.id)
        if session.scalar(others) and not session.scalar(others.where(Person.role == "admin")):
            raise Conflict(
                f"{person.name!r} is the last administrator, and the others would have none. Make another person "
                f"an administrator first, then {what} {person.name!r}.",
                code="last_admin",
            )

    def _publish(self, session: Session) -> None:
        """Notify all servers that secrets or roles have changed, so that they check the access of open pages again."""
        self._events.publish(session, "people", "", {})


def person_named(session: Session, name: str) -> Person:
    """Return the account with a name.

    Raises:
        NotFound: no such person.
    """
    person = session.scalars(select(Person).where(Person.key == name_key(name))).first()
    if person is None:
        raise NotFound(f"There is no person {name[:80]!r} here. 'tsr people list' shows the accounts.")
    return person


def name_key(name: str) -> str:
    """Normalise a name's case and Unicode form, so that two people cannot be mistaken for each other."""
    return unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", name).casefold())[:255]


def _check_name(name: str) -> str:
    if not 0 < len(name) <= _MAX_NAME_LENGTH or name != name.strip() or not name.isprintable():
        raise Invalid(
            f"A name has 1 to {_MAX_NAME_LENGTH} printable characters and no space at its ends, got {name[:100]!r}.",
            field="name",
        )
    return name


def _view(person: Person, assignments: int) -> PersonView:
    created = person.created.isoformat(timespec="seconds")
    return PersonView.from_row(person, created=created, assignments=assignments)
