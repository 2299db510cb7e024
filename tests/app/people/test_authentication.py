"""Authentication in a library with people: tokens, sessions, a proxy's header, and refusals."""

from __future__ import annotations

import asyncio
import threading
from types import SimpleNamespace
from typing import Any

import pytest
import requests
from starlette.testclient import TestClient

from app.events import EventBus
from app.people.service import PeopleService
from app.security.access import cookie_name
from tests.app.people.team import Team, make_team
from tests.app.threaded_server import serve_in_thread
from tests.app.toy_server import SECRET, Server
from tests.waiting import time_limit

PROXY, ELSEWHERE = ("10.0.0.9", 40000), ("192.0.2.1", 40000)


def error_of(answer: Any) -> tuple[int, str]:
    """Status and code; checks that the message is one line."""
    error = answer.json()["error"]
    assert "\n" not in error["message"]
    assert error["message"].endswith((".", ")."))
    return answer.status_code, error["code"]


def request_behind_proxy(server: Server, peer: tuple[str, int], *names: str) -> Any:
    """The response to a request with an address and headers that name people."""
    client = TestClient(server.app, base_url="http://127.0.0.1", raise_server_exceptions=False, client=peer)
    return client.get("/api/session", headers=[("X-Forwarded-User", name.encode()) for name in names])  # type: ignore[arg-type]


def test_a_library_without_people_is_unchanged(server_without_people: Server) -> None:
    session = server_without_people.client.get("/api/session").json()
    assert session["person"] is None
    assert session["author"] == "ada"
    assert server_without_people.client.post("/api/session/links").json()["path"].startswith("/login/")
    # a header with a person's name has no effect without people
    named = server_without_people.stranger()
    named.headers["X-Forwarded-User"] = "Ada"
    assert error_of(named.get("/api/session")) == (401, "unauthorised")
    assert "tsr review" in named.get("/api/session").json()["error"]["message"]
    assert error_of(server_without_people.stranger().post("/api/session", json={"token": SECRET})) == (
        401,
        "unauthorised",
    )


def test_a_person_signs_in_and_out(team_server: Server, team: Team) -> None:
    browser = team_server.stranger()
    answer = browser.post("/api/session", json={"token": team.tokens["Anna"]})
    assert answer.json() == {"name": "Anna", "role": "annotator", "can_sign_out": True}
    cookie = answer.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert "Secure" not in cookie
    assert team.tokens["Anna"] not in cookie
    session = browser.get("/api/session").json()
    assert (session["author"], session["person"]["role"]) == ("Anna", "annotator")
    kept = dict(browser.cookies)
    assert browser.delete("/api/session").status_code == 204
    assert error_of(browser.get("/api/session")) == (401, "signed_out")
    again = team_server.stranger()
    again.cookies.update(kept)
    assert error_of(again.get("/api/session")) == (401, "signed_out")  # ended on the server, not only in the browser
    assert team.client("Anna").get("/api/session").json()["person"]["can_sign_out"] is False


@pytest.mark.parametrize(
    ("peer", "headers", "secure"),
    [
        (("127.0.0.1", 1), {"X-Forwarded-Proto": "https"}, True),
        (PROXY, {"X-Forwarded-Proto": "https"}, True),
        (ELSEWHERE, {"X-Forwarded-Proto": "https"}, False),
        (ELSEWHERE, {"Origin": "https://127.0.0.1"}, True),
        (ELSEWHERE, {"Origin": "http://127.0.0.1"}, False),
    ],
)
def test_the_cookie_is_secure_behind_tls(
    team_server: Server, team: Team, peer: tuple[str, int], headers: dict[str, str], secure: bool
) -> None:
    client = TestClient(team_server.app, base_url="http://127.0.0.1", client=peer)
    answer = client.post("/api/session", json={"token": team.tokens["Anna"]}, headers=headers)
    assert answer.status_code == 200
    assert ("Secure" in answer.headers["set-cookie"]) is secure


def test_a_wrong_or_revoked_token_is_refused_in_one_sentence(team_server: Server, team: Team) -> None:
    client = team.client("Anna")
    assert client.get("/api/session").status_code == 200
    new = team_server.context.people.rotate("Anna")
    assert error_of(client.get("/api/session")) == (401, "revoked")
    assert "revoked" in client.get("/api/session").json()["error"]["message"]
    for wrong in (new[:-1], "tsr_x", "x" * 5000, "\u00fc"):
        headers = {"Authorization": f"Bearer {wrong}".encode()}
        assert error_of(team_server.stranger().get("/api/session", headers=headers)) == (401, "unauthorised")
        assert error_of(team_server.stranger().post("/api/session", json={"token": wrong[:200]})) == (
            401,
            "unauthorised",
        )
    client.headers["Authorization"] = f"Bearer {new}"
    assert client.get("/api/session").status_code == 200


def test_secrets_of_single_user_mode_end_with_the_first_person(team_server: Server, team: Team) -> None:
    old = {"Cookie": f"{cookie_name(80)}={team_server.context.tokens.cookie}"}
    assert error_of(team_server.stranger().get("/api/session", headers=old)) == (401, "signed_out")
    assert team_server.client.post("/api/session/links").json()["path"] == "/"
    link = team_server.stranger().get(
        f"/login/{team_server.context.tokens.new_link()}", headers={"Accept": "text/html"}
    )
    assert (link.status_code, link.headers["location"]) == (303, "/sign-in")
    assert "set-cookie" not in link.headers
    assert "Your token" in team_server.stranger().get("/sign-in").text


def test_the_secret_of_the_server_cannot_write_without_a_name(team_server: Server, team: Team) -> None:
    run = team_server.client.get("/api/videos").json()["videos"][0]["latest_run"]
    body = {"op_id": "1" * 12, "author": "ada", "command": {"name": "delete_track", "frame": 0, "key": "m1"}}
    answer = team_server.client.post(f"/api/runs/{run}/edits", json=body, headers={"If-Match": '"m1:0"'})
    assert error_of(answer) == (403, "no_person")


def test_a_trusted_proxy_names_the_person(team_server: Server, team: Team) -> None:
    answer = request_behind_proxy(team_server, PROXY, "anna")
    assert answer.json()["person"] == {"name": "Anna", "role": "annotator", "can_sign_out": False}
    assert request_behind_proxy(team_server, ("::ffff:10.0.0.9", 1), "Anna").status_code == 200
    assert request_behind_proxy(team_server, ("::1", 1), "Anna").status_code == 200
    unknown = request_behind_proxy(team_server, PROXY, "Eve")
    assert error_of(unknown) == (401, "no_account")
    assert "'Eve'" in unknown.json()["error"]["message"]
    assert error_of(request_behind_proxy(team_server, PROXY)) == (401, "signed_out")
    assert error_of(request_behind_proxy(team_server, PROXY, "")) == (401, "signed_out")
    assert error_of(request_behind_proxy(team_server, PROXY, "Anna", "Adam")) == (403, "bad_proxy")


@pytest.mark.parametrize("peer", [ELSEWHERE, ("127.0.0.1", 1), ("10.0.1.9", 1), ("testclient", 1)])
def test_the_header_of_a_proxy_is_refused_from_other_addresses(
    team_server: Server, team: Team, peer: tuple[str, int]
) -> None:
    answer = request_behind_proxy(team_server, peer, "Adam")
    assert error_of(answer) == (403, "bad_proxy")
    assert peer[0] in answer.json()["error"]["message"]
    # nor with a token: the request is contradictory
    client = TestClient(team_server.app, base_url="http://127.0.0.1", client=peer)
    client.headers["Authorization"] = f"Bearer {team.tokens['Anna']}"
    assert error_of(client.get("/api/session", headers={"X-Forwarded-User": "Adam"})) == (403, "bad_proxy")


def test_a_forwarded_address_does_not_make_a_trusted_proxy(team_server: Server, team: Team) -> None:
    with serve_in_thread(team_server) as made:
        said = {"X-Forwarded-For": "10.0.0.9", "X-Forwarded-User": "Adam", "Forwarded": "for=10.0.0.9"}
        answer = requests.get(f"{made.url}/api/session", headers=said, timeout=30)
    assert (answer.status_code, answer.json()["error"]["code"]) == (403, "bad_proxy")
    assert "127.0.0.1" in answer.json()["error"]["message"]


@pytest.mark.parametrize("how", ["rotate", "revoke", "remove", "sign_out"])
def test_revocation_ends_an_open_stream_at_once(server_without_people: Server, how: str) -> None:
    team = make_team(server_without_people)
    with serve_in_thread(server_without_people) as made:
        browser = requests.Session()
        browser.post(f"{made.url}/api/session", json={"token": team.tokens["Vera"]}, timeout=30).raise_for_status()
        with browser.get(f"{made.url}/api/events", stream=True, timeout=time_limit(30)) as stream:
            lines = stream.iter_lines()
            assert b"event: hello" in (next(lines), next(lines))
            ended = threading.Event()

            def read() -> None:
                for _ in lines:
                    pass
                ended.set()

            threading.Thread(target=read, daemon=True).start()
            server_without_people.context.people.set_role("Anna", "viewer")  # of another person: the stream continues
            assert not ended.wait(0.5)
            if how == "sign_out":
                browser.delete(f"{made.url}/api/session", timeout=30)
            else:
                getattr(server_without_people.context.people, how)("Vera")
            assert ended.wait(time_limit(5))
        assert browser.get(f"{made.url}/api/events", timeout=30).status_code == 401


def test_the_first_person_ends_the_stream_of_single_user_mode(server_without_people: Server) -> None:
    with (
        serve_in_thread(server_without_people) as made,
        requests.get(
            f"{made.url}/api/events", headers={"Authorization": f"Bearer {SECRET}"}, stream=True, timeout=time_limit(30)
        ) as stream,
    ):
        lines = stream.iter_lines()
        assert b"event: hello" in (next(lines), next(lines))
        server_without_people.context.people.add("Ada", "admin")
        assert sum(1 for _ in lines) < 50  # the stream ends


def test_removing_the_last_person_in_another_process_restores_single_user_mode(server_without_people: Server) -> None:
    _, token = server_without_people.context.people.add("Ada", "admin")
    server_without_people.context.directory.invalidate()
    ada = {"Authorization": f"Bearer {token}"}
    assert server_without_people.stranger().get("/api/session", headers=ada).json()["person"]["name"] == "Ada"
    assert server_without_people.client.post("/api/session/links").json()["path"] == "/"
    PeopleService(server_without_people.context.database, EventBus()).remove("Ada")  # this server is not notified
    assert error_of(server_without_people.stranger().get("/api/session", headers=ada)) == (401, "unauthorised")
    assert server_without_people.client.post("/api/session/links").json()["path"] != "/"


def test_nobody_is_admitted_during_a_database_outage(
    team_server: Server, team: Team, monkeypatch: pytest.MonkeyPatch
) -> None:
    from sqlalchemy.exc import OperationalError

    def away(*_: object) -> None:
        raise OperationalError(None, None, ConnectionError("away"))

    monkeypatch.setattr(team_server.context.directory, "by_secret", away)
    answer = team.client("Anna").get("/api/session")
    assert answer.status_code in (500, 503)
    assert "person" not in answer.text


def test_the_socket_of_a_view_ends_with_its_session(
    team_server: Server, team: Team, monkeypatch: pytest.MonkeyPatch
) -> None:
    from app.api import viser

    monkeypatch.setattr(viser, "ACCESS_CHECK_INTERVAL_S", 0.05)
    found, _ = team_server.context.directory.by_secret(team.tokens["Vera"], "token")

    socket = SimpleNamespace(app=team_server.app, scope={"tsr.identity": found})

    async def ends() -> None:
        watching = asyncio.ensure_future(viser.wait_for_access_loss(socket))  # type: ignore[arg-type]
        await asyncio.sleep(0.3)
        assert not watching.done()
        await asyncio.to_thread(team_server.context.people.revoke, "Vera")
        await asyncio.wait_for(watching, time_limit(5))

    asyncio.run(ends())
