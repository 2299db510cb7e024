"""Access is refused without credentials; names, origins, bodies and headers are checked."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from app.security.access import cookie_name
from app.settings import load_settings
from tests.app.toy_server import SECRET, Server
from tsr_engine.errors import UsageError

RUN, VIDEO = "0" * 32, "0" * 64
DOORS = (
    "/api/session",
    "/api/videos",
    f"/api/videos/{VIDEO}/frames/0",
    f"/api/videos/{VIDEO}/thumbnail",
    "/api/events",
    f"/api/runs/{RUN}/annotation",
    "/api/openapi.json",
    "/api/labels/1.png",
    "/nothing",
)


@pytest.mark.parametrize("path", DOORS)
def test_without_credentials_everything_is_401_without_details(server: Server, path: str) -> None:
    answer = server.stranger().get(path)
    assert answer.status_code == 401
    assert answer.json()["error"]["code"] == "unauthorised"
    for wrong in ("Bearer wrong", f"Basic {SECRET}", "Bearer", f"Bearer {SECRET}x", "Bearer \xfc"):
        headers = {"Authorization": wrong.encode("latin-1")}
        assert server.stranger().get(path, headers=headers).status_code == 401


def test_a_link_opens_the_page_once(server: Server) -> None:
    path = server.client.post("/api/session/links").json()["path"]
    browser = server.stranger()
    first = browser.get(path)
    assert first.status_code == 303
    assert first.headers["location"] == "/"
    cookie = first.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert SECRET not in cookie
    assert browser.get("/api/session").status_code == 200
    assert server.stranger().get(path).status_code == 401
    assert server.stranger().get("/login/guess").status_code == 401


def test_a_used_link_works_in_its_session_and_explains_itself_to_others(server: Server) -> None:
    path = server.client.post("/api/session/links").json()["path"]
    browser = server.stranger()
    page = {"Accept": "text/html,application/xhtml+xml,*/*;q=0.8"}
    browser.get(path)
    again = browser.get(path, headers=page)
    assert (again.status_code, again.headers["location"]) == (303, "/")
    stranger = server.stranger()
    other = stranger.get(path, headers=page)
    assert other.status_code == 303
    assert "set-cookie" not in other.headers
    reported = stranger.get(other.headers["location"])
    assert (reported.status_code, "This link has been used" in reported.text) == (200, True)
    program = server.stranger().get(path)
    assert (program.status_code, program.json()["error"]["code"]) == (401, "unauthorised")


def test_the_cookie_survives_a_restart(server: Server) -> None:
    name = cookie_name(80)
    headers = {"Cookie": f"{name}={server.context.tokens.cookie}"}
    again = Server(server.settings.home)
    assert again.stranger().get("/api/session", headers=headers).status_code == 200
    assert again.stranger().get("/api/session", headers={"Cookie": f"{name}=x; {name}"}).status_code == 401
    again.context.close()


def test_odd_cookies_of_other_programs_do_no_harm(server: Server) -> None:
    name = cookie_name(80)
    session_cookie = f"{name}={server.context.tokens.cookie}"
    for header in (
        f'other={{"a": 1}}; {session_cookie}',
        f"{name}=stale; {session_cookie}",
        f"; ;=;a;{session_cookie}",
        f'q="x;y"; {session_cookie}',
    ):
        assert server.stranger().get("/api/session", headers={"Cookie": header}).status_code == 200, header
    assert server.stranger().get("/api/session", headers={"Cookie": f"x{session_cookie}"}).status_code == 401


@pytest.mark.parametrize(
    "host", ["127.0.0.1.evil.example", "evil.example", "localhost.evil", "127.0.0.1:80@evil", "", "127.0.0.1:x", "[::1"]
)
def test_a_foreign_host_is_refused_on_every_path(server: Server, host: str) -> None:
    for path in ("/", "/api/session", "/static/index.html"):
        answer = server.client.get(path, headers={"Host": host})
        assert answer.status_code == 400, path
        assert answer.json()["error"]["code"] == "bad_host"
        assert "TSR_ALLOWED_HOSTS" in answer.json()["error"]["message"]


def test_our_own_names_are_accepted(server: Server) -> None:
    for host in ("127.0.0.1", "localhost", "LOCALHOST:8765", "127.0.0.1:1", "[::1]:9"):
        assert server.client.get("/api/session", headers={"Host": host}).status_code == 200


def test_the_reached_address_and_configured_names_are_accepted(tmp_path: Path) -> None:
    from starlette.testclient import TestClient

    def asked(name: str, *, reached: str, **settings: object) -> int:
        server = Server(tmp_path / "home", **settings)
        client = TestClient(server.app, base_url=f"http://{reached}")
        client.headers["Authorization"] = f"Bearer {SECRET}"
        status = client.get("/api/session", headers={"Host": name}).status_code
        server.context.close()
        return status

    for host in ("192.0.2.7:8765", "127.0.0.1:8765", "drive.Example:1"):
        assert asked(host, reached="192.0.2.7", host="0.0.0.0", allowed_hosts=("drive.example",)) == 200, host
    assert asked("192.0.2.7", reached="192.0.2.7", host="192.0.2.7") == 200
    assert asked("box.example", reached="192.0.2.7", host="box.example") == 200
    assert asked("[2001:db8::1]:80", reached="192.0.2.7", host="2001:db8::1") == 200
    for host in ("192.0.2.8", "0.0.0.0", "evil.example"):
        assert asked(host, reached="192.0.2.7", host="0.0.0.0") == 400, host
    assert asked("192.0.2.7", reached="evil.example", host="0.0.0.0") == 400


NO_ORIGINS = (
    "http://[",
    "http://[::1",
    "http://[x]",
    "127.0.0.1",
    "http:/127.0.0.1",
    "http://127.0.0.1@evil",
    "\xff://",
    "://127.0.0.1",
    "ftp://127.0.0.1",
    "file://127.0.0.1",
    "ws://127.0.0.1",
)


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:9999"},
        {"Origin": ""},
        *({"Origin": origin.encode("latin-1")} for origin in NO_ORIGINS),
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
)
def test_requests_of_other_pages_are_refused(server: Server, headers: dict[str, str | bytes]) -> None:
    for method, path in (
        ("POST", "/api/session/links"),
        ("DELETE", f"/api/videos/{VIDEO}"),
        ("PUT", "/api/uploads/a.mp4"),
        ("POST", f"/api/runs/{RUN}/cancel"),
    ):
        answer = server.client.request(method, path, headers=headers)
        assert answer.status_code == 403, (method, path)
        assert answer.json()["error"]["code"] == "bad_origin"
    assert server.client.post("/api/session/links", headers={"Origin": "http://127.0.0.1"}).status_code == 201


def test_an_origin_must_have_the_served_or_proxied_scheme(server: Server) -> None:
    from starlette.testclient import TestClient

    def asked(base: str, origin: str) -> int:
        client = TestClient(server.app, base_url=base)
        headers = {"Authorization": f"Bearer {SECRET}", "Origin": origin}
        return client.post("/api/session/links", headers=headers).status_code

    assert asked("http://127.0.0.1", "http://127.0.0.1") == 201
    assert asked("http://127.0.0.1", "https://127.0.0.1") == 201, "the proxy takes TLS off"
    assert asked("https://127.0.0.1", "HTTPS://127.0.0.1") == 201
    assert asked("https://127.0.0.1", "http://127.0.0.1") == 403


def test_sockets_have_the_same_checks(server: Server) -> None:
    from starlette.websockets import WebSocketDisconnect

    known = {"Authorization": f"Bearer {SECRET}"}
    foreign = [{**known, "Origin": origin} for origin in ("http://evil.example", "http://[", "ftp://127.0.0.1")]
    for extra, code in (({}, 4401), *((one, 4403) for one in foreign)):
        headers = {"Host": "127.0.0.1", **extra}
        with (
            pytest.raises(WebSocketDisconnect) as refused,
            server.stranger().websocket_connect("/viser", headers=headers),
        ):
            pass
        assert refused.value.code == code, extra


def test_every_answer_has_the_security_headers(server: Server) -> None:
    for answer in (
        server.client.get("/api/session"),
        server.stranger().get("/api/session"),
        server.client.get("/"),
        server.client.get("/api/nothing"),
    ):
        policy = answer.headers["content-security-policy"]
        assert "default-src 'self'" in policy
        assert "unsafe-inline" not in policy
        assert "frame-ancestors 'none'" in policy
        assert answer.headers["x-content-type-options"] == "nosniff"
    let_in = server.client.get("/api/session").headers
    assert let_in["cache-control"] == "no-store"
    assert re.fullmatch(r"total;dur=\d+\.\d", let_in["server-timing"])
    assert "server-timing" not in server.stranger().get("/api/videos").headers


def test_large_bodies_are_refused_with_and_without_a_length(server: Server) -> None:
    limit = server.settings.body_max_kb * 1024
    assert server.client.post("/api/videos", content=b"x" * (limit + 1)).status_code == 413

    def chunks() -> object:
        for _ in range(limit // 65536 + 2):
            yield b"x" * 65536

    answer = server.client.post("/api/videos", content=chunks(), headers={"Content-Type": "application/json"})
    assert answer.status_code == 413
    assert answer.json()["error"]["code"] == "too_large"
    for length in ("9" * 5000, "-1", "1_0", "x"):
        answer = server.client.post("/api/session/links", headers={"Content-Length": length})
        assert answer.status_code == 400, length
        assert answer.json()["error"]["code"] == "bad_request"


def test_errors_have_one_format(server: Server) -> None:
    cases = [
        ("GET", "/api/nothing", None, 404),
        ("PATCH", "/api/videos", None, 405),
        ("POST", "/api/videos", b"{", 422),
        ("POST", "/api/videos", b'{"path": 3}', 422),
        ("POST", "/api/videos", b'{"path": "/a", "more": 1}', 422),
        ("GET", f"/api/videos/{VIDEO}", None, 404),
        ("GET", "/api/videos/../../etc/passwd", None, 404),
        ("GET", f"/api/videos/{VIDEO}/frames/-1", None, 422),
        ("GET", f"/api/videos/{VIDEO}/frames/99999999999999999999", None, 422),
        ("GET", f"/api/runs/{RUN}", None, 404),
        ("GET", "/api/runs/%00", None, 422),
    ]
    for method, path, body, status in cases:
        answer = server.client.request(method, path, content=body, headers={"Content-Type": "application/json"})
        assert answer.status_code == status, (method, path, answer.text)
        error = answer.json()["error"]
        assert set(error) == {"code", "message", "field", "details"}
        assert error["message"].endswith(".")


def test_invalid_numbers_are_refused(server: Server) -> None:
    for text in ("NaN", "Infinity", "-Infinity", "1e999"):
        body = '{"op_id": "12345678", "author": "a", "command": {"name": "set_box", "frame": 1, "key": "m1", '
        body += f'"box": [{text}, 1, 2, 3]}}}}'
        answer = server.client.post(
            f"/api/runs/{RUN}/edits", content=body.encode(), headers={"Content-Type": "application/json"}
        )
        assert answer.status_code == 422, text
        assert "box" in answer.json()["error"]["field"]


def test_an_unexpected_error_leaks_nothing(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> None:
        raise RuntimeError("a secret detail")

    monkeypatch.setattr(type(server.context.videos), "listing", lambda _: fail())
    answer = server.client.get("/api/videos")
    assert answer.status_code == 500
    assert "secret detail" not in answer.text
    assert "Traceback" not in answer.text
    assert answer.json()["error"]["code"] == "internal"
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["cache-control"] == "no-store"
    assert "frame-ancestors 'none'" in answer.headers["content-security-policy"]


def test_page_files_outside_the_folder_are_not_served(server: Server) -> None:
    for path in (
        "/static/../app/main.py",
        "/static/%2e%2e/app/main.py",
        "/static/..%2fapp/main.py",
        "/static//etc/passwd",
    ):
        assert server.client.get(f"/static/{path}").status_code in (400, 404), path


def test_an_open_address_needs_a_secret() -> None:
    with pytest.raises(UsageError, match="TSR_TOKEN"):
        load_settings(host="0.0.0.0")
    assert load_settings(host="0.0.0.0", token=SECRET).host == "0.0.0.0"
