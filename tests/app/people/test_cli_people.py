"""``tsr people``: every command, on an existing library."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from app.cli.main import run
from app.people.directory import Directory
from app.settings import Settings
from app.storage.database import Database
from tests.app.databases import put_tables


class Command:
    """The command line on one data folder."""

    def __init__(self, home: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.home, self._capsys = home, capsys

    def __call__(self, *words: object, code: int = 0) -> tuple[str, str]:
        """Output and error output of a command; ``code``: its expected exit code."""
        self._capsys.readouterr()
        ended = run(["people", *map(str, words), "--home", str(self.home)])
        captured = self._capsys.readouterr()
        assert ended == code, captured.err
        return captured.out.strip(), captured.err.strip()


@pytest.fixture
def tsr(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Command:
    """The command line on an empty library."""
    settings = Settings(home=tmp_path / "home", database_url=None)
    settings.home.mkdir()
    put_tables(settings.home / "tsr.sqlite")
    return Command(settings.home, capsys)


def is_token_accepted(tsr: Command, token: str) -> bool:
    """Whether a token is accepted."""
    database = Database(Settings(home=tsr.home, database_url=None).database)
    found, _ = Directory(database).by_secret(token, "token")
    database.close()
    return found is not None


def test_people_are_added_changed_and_removed(tsr: Command) -> None:
    assert "one user" in tsr("list")[1]
    link, said = tsr("add", "Ada", "--role", "admin", "--url", "https://tsr.example/")
    assert link.startswith("https://tsr.example/sign-in#tsr_")
    assert "only once" in said
    assert "From now on everybody signs in" in said
    token = link.partition("#")[2]
    assert is_token_accepted(tsr, token)
    made = json.loads(tsr("add", "Bob", "--role", "viewer", "--json")[0])
    assert made["link"] == f"http://127.0.0.1:8765/sign-in#{made['token']}"
    assert tsr("role", "bob", "reviewer")[1].endswith("Bob has the role reviewer.")
    second = json.loads(tsr("token", "Bob", "--note", "script", "--json")[0])["token"]
    (tsr.home / "server.json").write_text('{"base": "http://127.0.0.1:9999", "pid": 1}')
    rotated = tsr("rotate", "Ada")[0]
    assert rotated.startswith("http://127.0.0.1:9999/sign-in#")
    assert not is_token_accepted(tsr, token)
    listed = json.loads(tsr("list", "--json")[0])["people"]
    assert [(one["name"], one["role"]) for one in listed] == [("Ada", "admin"), ("Bob", "reviewer")]
    (identity,) = [one["id"] for one in listed[1]["tokens"] if one["note"] == "script"]
    assert identity in tsr("list")[0]
    assert second not in tsr("list")[0]
    assert "1 token of Bob is revoked" in tsr("revoke", "Bob", "--token", identity)[1]
    assert (is_token_accepted(tsr, second), is_token_accepted(tsr, made["token"])) == (False, True)
    assert "Bob is removed and signed out" in tsr("remove", "Bob")[1]
    assert "one user again" in tsr("remove", "Ada")[1]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("add", "Ada", "--role", "boss"), "Expected one of the roles viewer, annotator, reviewer, admin, got 'boss'."),
        (("add", " ", "--role", "admin"), "printable characters"),
        (("role", "Eve", "admin"), "There is no person 'Eve' here."),
        (("remove", "Eve"), "There is no person 'Eve' here."),
        (("rotate", "Eve"), "There is no person 'Eve' here."),
        (("token", "Eve"), "There is no person 'Eve' here."),
        (("revoke", "Eve"), "There is no person 'Eve' here."),
    ],
)
def test_refusals_are_one_sentence(tsr: Command, words: tuple[str, ...], sentence: str) -> None:
    out, said = tsr(*words, code=2)
    assert out == ""
    assert sentence in said
    assert "Traceback" not in said


def test_a_first_person_without_administration_causes_a_warning(tsr: Command) -> None:
    assert "is not an administrator" in tsr("add", "Vera", "--role", "viewer")[1]
