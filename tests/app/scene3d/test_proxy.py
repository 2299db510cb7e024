"""Access to a view: permissions, forwarded data, and its end."""

from __future__ import annotations

import math
import socket as sockets
import time

import pytest
import requests
from websockets.exceptions import ConnectionClosed, InvalidStatus

from app.security.access import cookie_name
from tests.app.scene3d.scene3d_desk import (
    AUTHORISED,
    HEAD,
    PATIENCE,
    PROTOCOL,
    Desk,
    is_closed,
    look,
    open_desk,
    read_to_the_end,
    read_until,
    until,
)
from tests.app.toy_home import ToyHome


def cookie(desk: Desk) -> str:
    return f"{cookie_name(desk.live.port)}={desk.live.server.context.tokens.cookie}"


def test_the_page_needs_the_cookie(desk: Desk) -> None:
    address = f"{desk.live.url}/viser/{desk.run}/{desk.name()}"
    refused = requests.get(address, timeout=PATIENCE)
    assert refused.status_code == 401
    assert refused.json()["error"]["code"] == "unauthorised"
    answer = requests.get(address, headers={"Cookie": cookie(desk)}, timeout=PATIENCE)
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/html")
    policy = answer.headers["content-security-policy"]
    assert "frame-ancestors 'self'" in policy
    assert "script-src 'sha256-" in policy
    again = requests.get(
        address, headers={"Cookie": cookie(desk), "If-None-Match": answer.headers["etag"]}, timeout=PATIENCE
    )
    assert again.status_code == 304


def test_the_page_of_the_review_may_frame_its_own_pages_only(desk: Desk) -> None:
    policy = requests.get(desk.live.url, timeout=PATIENCE).headers["content-security-policy"]
    assert "frame-src 'self'" in policy


def test_a_foreign_host_name_is_refused(desk: Desk) -> None:
    address = f"{desk.live.url}/viser/{desk.run}/{desk.name()}"
    answer = requests.get(address, headers={**AUTHORISED, "Host": "evil.example"}, timeout=PATIENCE)
    assert answer.status_code == 400
    assert answer.json()["error"]["code"] == "bad_host"


@pytest.mark.parametrize("path", ["", "/", "/../../etc/passwd", "/assets/x.js", "/%2e%2e/x"])
def test_other_paths_are_not_served(desk: Desk, path: str) -> None:
    assert desk.call("GET", f"/viser{path}").status_code in (404, 422)
    assert desk.call("GET", f"/viser/{desk.run}/{desk.name()}/index.html{path}").status_code in (404, 422)


def test_an_unknown_run_has_no_page(desk: Desk) -> None:
    answer = desk.call("GET", f"/viser/{'0' * 32}/{desk.name()}")
    assert answer.status_code == 404
    assert answer.json()["error"]["message"].startswith("There is no run")


@pytest.mark.parametrize(
    ("named", "headers"),
    [
        ("nobody", {"Origin": "OWN"}),
        ("wrong token", {"Origin": "OWN", "Authorization": "Bearer " + "x" * 24}),
        ("foreign origin", {**AUTHORISED, "Origin": "http://evil.example"}),
        ("other port", {**AUTHORISED, "Origin": "http://127.0.0.1:1"}),
        ("origin of a sandbox", {**AUTHORISED, "Origin": "null"}),
        ("told by the browser", {**AUTHORISED, "Origin": "OWN", "Sec-Fetch-Site": "cross-site"}),
        ("foreign name", {**AUTHORISED, "Host": "evil.example", "Origin": "http://evil.example"}),
    ],
)
def test_sockets_need_credentials(desk: Desk, named: str, headers: dict[str, str]) -> None:
    given = {name: desk.live.url if value == "OWN" else value for name, value in headers.items()}
    before = len(desk.scene3d.views())
    if "Host" in given:
        # the client library sets the Host header itself: write it by hand
        lines = [
            f"GET /viser/{desk.run}/{desk.name()} HTTP/1.1", "Upgrade: websocket", "Connection: Upgrade",
            "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
            f"Sec-WebSocket-Protocol: {PROTOCOL}", *(f"{name}: {value}" for name, value in given.items()),
        ]  # fmt: skip
        with sockets.create_connection(("127.0.0.1", desk.live.port), timeout=PATIENCE) as line:
            line.sendall("\r\n".join([*lines, "", ""]).encode())
            assert line.recv(64).startswith(b"HTTP/1.1 403"), named
    else:
        with pytest.raises(InvalidStatus) as refused, desk.socket(desk.name(), given):
            pass
        assert refused.value.response.status_code == 403, named
    assert len(desk.scene3d.views()) == before, "nothing is started for strangers"


def test_the_cookie_opens_the_socket_with_and_without_a_slash(desk: Desk) -> None:
    headers = {"Cookie": cookie(desk), "Origin": desk.live.url}
    for slash in ("", "/"):
        with desk.socket(desk.name(), headers, slash=slash) as line:
            assert line.subprotocol == PROTOCOL
            look(line)
            assert read_until(line, b"/volume/lines")


def test_a_view_outlives_the_deadline_of_its_request(desk: Desk) -> None:
    with desk.socket(desk.name()) as line:
        look(line)
        read_until(line, b"/volume/lines")
        time.sleep(1.5 * HEAD)
        assert line.ping().wait(PATIENCE), "the socket was cut"


def test_only_viser_pages_are_accepted_as_clients(desk: Desk) -> None:
    with pytest.raises(InvalidStatus), desk.socket(desk.name(), subprotocols=None):
        pass
    with pytest.raises(InvalidStatus), desk.socket("no-hex-name"):
        pass


def test_another_version_of_viser_is_disconnected(desk: Desk) -> None:
    with desk.socket(desk.name(), subprotocols=["viser-v0.0.1"]) as line, pytest.raises(ConnectionClosed):
        read_to_the_end(line)


def test_the_page_is_notified_when_the_view_ends(desk: Desk) -> None:
    name = desk.name()
    with desk.socket(name) as line:
        line.recv(timeout=PATIENCE)
        desk.scene3d.forget(desk.run)
        with pytest.raises(ConnectionClosed):
            read_to_the_end(line)


def test_an_idle_view_is_stopped_and_opens_again(desk: Desk) -> None:
    """Independent of the machine's speed: a view is idle at once without a page, or never."""
    desk.scene3d.forget(desk.run)
    name, usual = desk.name(), desk.scene3d.idle
    desk.scene3d.idle = 0.0
    try:
        with desk.socket(name) as line:
            line.recv(timeout=PATIENCE)
            port = desk.scene3d.views()[desk.run, name].host.port
            for _ in range(3):
                desk.scene3d.stop_idle()
            assert len(desk.scene3d.views()) == 1, "somebody looks"
        until(lambda: len(desk.scene3d.views()) == 0)  # without a request
        until(lambda: is_closed(port))
        desk.scene3d.idle = math.inf
        with desk.socket(name) as line:
            assert line.recv(timeout=PATIENCE)
            view = desk.scene3d.views()[desk.run, name]
        until(lambda: view.clients == 0)
        desk.scene3d.stop_idle()
        assert len(desk.scene3d.views()) == 1, "it waits for somebody to come back"
    finally:
        desk.scene3d.idle = usual


def test_too_many_views_are_refused_but_idle_ones_are_replaced(desk: Desk) -> None:
    desk.scene3d.forget(desk.run)
    lines = [desk.socket(desk.name()) for _ in range(4)]
    try:
        with pytest.raises(InvalidStatus), desk.socket(desk.name()):
            pass
    finally:
        for line in lines:
            line.close()
    until(lambda: all(view.clients == 0 for view in desk.scene3d.views().values()))
    with desk.socket(desk.name()) as line:
        assert line.recv(timeout=PATIENCE)
    assert len(desk.scene3d.views()) <= 4


def test_an_open_view_does_not_delay_shutdown(toy: ToyHome) -> None:
    with open_desk(toy) as desk, desk.socket(desk.name()) as line:
        line.recv(timeout=PATIENCE)
        assert desk.live.stop() < PATIENCE / 2
        with pytest.raises(ConnectionClosed):
            read_to_the_end(line)
