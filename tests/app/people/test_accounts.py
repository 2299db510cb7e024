"""Accounts on both databases: names, roles, tokens that are stored as hashes, rotation and revocation."""

from __future__ import annotations

import pytest
from sqlalchemy import select

from app.errors import ApiError, Conflict, Invalid, NotFound
from app.events import EventBus
from app.people.directory import Directory
from app.people.service import PeopleService
from app.storage.database import Database
from app.storage.models import Person, PersonSecret


def test_the_first_person_ends_single_user_mode(people: PeopleService, directory: Directory) -> None:
    assert directory.is_empty()
    people.add("Ada", "admin")
    directory.invalidate()
    assert not directory.is_empty()
    people.remove("Ada")
    assert directory.is_empty()


def test_another_process_adds_the_first_person(database: Database, people: PeopleService, directory: Directory) -> None:
    directory.is_empty()
    assert directory.is_known_empty
    other = Database(database.engine.url)
    PeopleService(other, EventBus()).add("Ada", "admin")
    other.close()
    directory._valid_until = 0.5  # a second later
    assert not directory.is_empty()


def test_only_the_hash_of_a_token_is_stored(database: Database, people: PeopleService, directory: Directory) -> None:
    view, token = people.add("Ada", "reviewer")
    assert (view.name, view.role) == ("Ada", "reviewer")
    assert len(token) > 40
    with database.read() as session:
        rows = session.scalars(select(PersonSecret)).all()
        stored = " ".join(str(value) for row in rows for value in vars(row).values())
    assert token not in stored
    assert token.removeprefix("tsr_") not in stored
    found, revoked = directory.by_secret(token, "token")
    assert found is not None
    assert (found.name, found.role, revoked) == ("Ada", "reviewer", False)
    assert directory.by_secret(token, "session") == (None, False)  # a token is not a cookie
    assert directory.by_secret(token[:-1], "token") == (None, False)


def test_names_that_look_equal_are_one_name(people: PeopleService) -> None:
    people.add("Zoë", "viewer")
    for name in ("Zoë", "zoë", "ZOË", "Zoe\u0308"):
        with pytest.raises(Conflict, match="already"):
            people.add(name, "viewer")
    assert people.set_role("zoe\u0308", "annotator").name == "Zoë"


@pytest.mark.parametrize("name", ["", " Ada", "Ada ", "a\nb", "a\x00b", "x" * 81, "\u202eada"])
def test_invalid_names_are_refused_in_a_sentence(people: PeopleService, name: str) -> None:
    with pytest.raises(Invalid, match="1 to 80 printable characters"):
        people.add(name, "viewer")
    assert people.views() == []


def test_rotation_ends_every_token_and_session_and_gives_one_new(people: PeopleService, directory: Directory) -> None:
    _, first = people.add("Ada", "admin")
    second = people.new_token("Ada", "nightly export")
    _, session = directory.sign_in(first)
    assert [token.note for token in people.tokens("Ada")] == ["first token", "nightly export"]
    new = people.rotate("Ada")
    for old in (first, second):
        assert directory.by_secret(old, "token") == (None, True)
    assert directory.by_secret(session, "session") == (None, True)
    assert directory.sign_in(first) == (None, "")
    found, _ = directory.by_secret(new, "token")
    assert found is not None
    assert len(people.tokens("Ada")) == 1


def test_one_token_is_revoked_by_its_id(people: PeopleService, directory: Directory) -> None:
    _, first = people.add("Ada", "admin")
    script = people.new_token("Ada", "script")
    _, session = directory.sign_in(first)
    (identity,) = [token.id for token in people.tokens("Ada") if token.note == "script"]
    assert people.revoke("Ada", identity) == 1
    assert directory.by_secret(script, "token") == (None, True)
    assert directory.by_secret(first, "token")[0] is not None
    assert directory.by_secret(session, "session") == (None, True)
    for wrong in (identity, "00000000", ""):
        with pytest.raises(NotFound, match="has no token"):
            people.revoke("Ada", wrong)
    assert people.revoke("Ada") == 1
    assert people.revoke("Ada") == 0


def test_a_removed_person_is_not_admitted(people: PeopleService, directory: Directory) -> None:
    _, token = people.add("Ada", "admin")
    by_token, _ = directory.by_secret(token, "token")
    by_proxy = directory.by_name("ADA")
    by_session, secret = directory.sign_in(token)
    assert by_token is not None
    assert by_proxy is not None
    assert by_session is not None
    in_session, _ = directory.by_secret(secret, "session")
    assert in_session is not None
    assert all(map(directory.has_access, (by_token, by_proxy, in_session)))
    directory.sign_out(in_session)
    assert not directory.has_access(in_session)
    people.revoke("Ada")
    assert not directory.has_access(by_token)
    assert directory.has_access(by_proxy)
    people.remove("Ada")
    assert not directory.has_access(by_proxy)


def test_the_last_administrator_cannot_leave_before_the_others(people: PeopleService) -> None:
    people.add("Ada", "admin")
    people.add("Bob", "viewer")
    for attempt in (lambda: people.remove("Ada"), lambda: people.set_role("Ada", "reviewer")):
        with pytest.raises(Conflict, match="last administrator"):
            attempt()
    people.set_role("Bob", "admin")
    people.set_role("Ada", "viewer")
    people.remove("Ada")
    people.remove("Bob")  # single-user mode again
    assert people.views() == []


def test_removing_a_person_removes_their_secrets(database: Database, people: PeopleService) -> None:
    people.add("Ada", "admin")
    people.new_token("Ada")
    people.remove("Ada")
    with database.read() as session:
        assert session.scalars(select(PersonSecret)).all() == []
        assert session.scalars(select(Person)).all() == []


def test_unknown_people_are_refused(people: PeopleService) -> None:
    attempts = (
        lambda: people.remove("Eve"),
        lambda: people.set_role("Eve", "admin"),
        lambda: people.new_token("Eve"),
        lambda: people.rotate("Eve"),
        lambda: people.revoke("Eve"),
        lambda: people.tokens("Eve"),
    )
    for attempt in attempts:
        with pytest.raises(ApiError, match="no person 'Eve'"):
            attempt()
