"""Access to a view: permissions, forwarded data, and its end."""

from __future__ import annotations

import math
import socket as sockets
import time

import pytest
import requests
from websockets.exceptions import ConnectionClosed, InvalidStatus

from app.security.access import cookie_name
from tests.app.scene3d.scene3d_client import (
    AUTHORISED,
    HEAD_TIMEOUT_S,
    MAX_WAIT_S,
    PROTOCOL,
    Scene3dClient,
    is_closed,
    open_client,
    read_to_the_end,
    read_until,
    send_camera,
)
from tests.app.toy_home import ToyHome
from tests.waiting import wait_until


def cookie(api: Scene3dClient) -> str:
    return f"{cookie_name(api.server.port)}={api.server.server.context.tokens.cookie}"


def test_the_page_needs_the_cookie(api: Scene3dClient) -> None:
    address = f"{api.server.url}/viser/{api.run}/{api.name()}"
    refused = requests.get(address, timeout=MAX_WAIT_S)
    assert refused.status_code == 401
    assert refused.json()["error"]["code"] == "unauthorised"
    answer = requests.get(address, headers={"Cookie": cookie(api)}, timeout=MAX_WAIT_S)
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/html")
    policy = answer.headers["content-security-policy"]
    assert "frame-ancestors 'self'" in policy
    assert "script-src 'sha256-" in policy
    again = requests.get(
        address, headers={"Cookie": cookie(api), "If-None-Match": answer.headers["etag"]}, timeout=MAX_WAIT_S
    )
    assert again.status_code == 304


def test_the_page_of_the_review_may_frame_its_own_pages_only(api: Scene3dClient) -> None:
    policy = requests.get(api.server.url, timeout=MAX_WAIT_S).headers["content-security-policy"]
    assert "frame-src 'self'" in policy


def test_a_foreign_host_name_is_refused(api: Scene3dClient) -> None:
    address = f"{api.server.url}/viser/{api.run}/{api.name()}"
    answer = requests.get(address, headers={**AUTHORISED, "Host": "evil.example"}, timeout=MAX_WAIT_S)
    assert answer.status_code == 400
    assert answer.json()["error"]["code"] == "bad_host"


@pytest.mark.parametrize("path", ["", "/", "/../../etc/passwd", "/assets/x.js", "/%2e%2e/x"])
def test_other_paths_are_not_served(api: Scene3dClient, path: str) -> None:
    assert api.call("GET", f"/viser{path}").status_code in (404, 422)
    assert api.call("GET", f"/viser/{api.run}/{api.name()}/index.html{path}").status_code in (404, 422)


def test_an_unknown_run_has_no_page(api: Scene3dClient) -> None:
    answer = api.call("GET", f"/viser/{'0' * 32}/{api.name()}")
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
def test_sockets_need_credentials(api: Scene3dClient, named: str, headers: dict[str, str]) -> None:
    given = {name: api.server.url if value == "OWN" else value for name, value in headers.items()}
    before = len(api.scene3d.views())
    if "Host" in given:
        # the client library sets the Host header itself: write it by hand
        lines = [
            f"GET /viser/{api.run}/{api.name()} HTTP/1.1", "Upgrade: websocket", "Connection: Upgrade",
            "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
            f"Sec-WebSocket-Protocol: {PROTOCOL}", *(f"{name}: {value}" for name, value in given.items()),
        ]  # fmt: skip
        with sockets.create_connection(("127.0.0.1", api.server.port), timeout=MAX_WAIT_S) as line:
            line.sendall("\r\n".join([*lines, "", ""]).encode())
            assert line.recv(64).startswith(b"HTTP/1.1 403"), named
    else:
        with pytest.raises(InvalidStatus) as refused, api.socket(api.name(), given):
            pass
        assert refused.value.response.status_code == 403, named
    assert len(api.scene3d.views()) == before, "nothing is started for strangers"


def test_the_cookie_opens_the_socket_with_and_without_a_slash(api: Scene3dClient) -> None:
    headers = {"Cookie": cookie(api), "Origin": api.server.url}
    for slash in ("", "/"):
        with api.socket(api.name(), headers, slash=slash) as line:
            assert line.subprotocol == PROTOCOL
            send_camera(line)
            assert read_until(line, b"/volume/lines")


def test_a_view_outlives_the_deadline_of_its_request(api: Scene3dClient) -> None:
    with api.socket(api.name()) as line:
        send_camera(line)
        read_until(line, b"/volume/lines")
        time.sleep(1.5 * HEAD_TIMEOUT_S)
        assert line.ping().wait(MAX_WAIT_S), "the socket was cut"


def test_only_viser_pages_are_accepted_as_clients(api: Scene3dClient) -> None:
    with pytest.raises(InvalidStatus), api.socket(api.name(), subprotocols=None):
        pass
    with pytest.raises(InvalidStatus), api.socket("no-hex-name"):
        pass


def test_another_version_of_viser_is_disconnected(api: Scene3dClient) -> None:
    with api.socket(api.name(), subprotocols=["viser-v0.0.1"]) as line, pytest.raises(ConnectionClosed):
        read_to_the_end(line)


def test_the_page_is_notified_when_the_view_ends(api: Scene3dClient) -> None:
    name = api.name()
    with api.socket(name) as line:
        line.recv(timeout=MAX_WAIT_S)
        api.scene3d.forget(api.run)
        with pytest.raises(ConnectionClosed):
            read_to_the_end(line)


def test_an_idle_view_is_stopped_and_opens_again(api: Scene3dClient) -> None:
    """Independent of the machine's speed: a view is idle at once without a page, or never."""
    api.scene3d.forget(api.run)
    name, usual = api.name(), api.scene3d.idle
    api.scene3d.idle = 0.0
    try:
        with api.socket(name) as line:
            line.recv(timeout=MAX_WAIT_S)
            port = api.scene3d.views()[api.run, name].host.port
            for _ in range(3):
                api.scene3d.stop_idle()
            assert len(api.scene3d.views()) == 1, "somebody looks"
        wait_until(lambda: len(api.scene3d.views()) == 0)  # without a request
        wait_until(lambda: is_closed(port))
        api.scene3d.idle = math.inf
        with api.socket(name) as line:
            assert line.recv(timeout=MAX_WAIT_S)
            view = api.scene3d.views()[api.run, name]
        wait_until(lambda: view.clients == 0)
        api.scene3d.stop_idle()
        assert len(api.scene3d.views()) == 1, "it waits for somebody to come back"
    finally:
        api.scene3d.idle = usual


def test_too_many_views_are_refused_but_idle_ones_are_replaced(api: Scene3dClient) -> None:
    api.scene3d.forget(api.run)
    lines = [api.socket(api.name()) for _ in range(4)]
    try:
        with pytest.raises(InvalidStatus), api.socket(api.name()):
            pass
    finally:
        for line in lines:
            line.close()
    wait_until(lambda: all(view.clients == 0 for view in api.scene3d.views().values()))
    with api.socket(api.name()) as line:
        assert line.recv(timeout=MAX_WAIT_S)
    assert len(api.scene3d.views()) <= 4


def test_an_open_view_does_not_delay_shutdown(toy: ToyHome) -> None:
    with open_client(toy) as api, api.socket(api.name()) as line:
        line.recv(timeout=MAX_WAIT_S)
        assert api.server.stop() < MAX_WAIT_S / 2
        with pytest.raises(ConnectionClosed):
            read_to_the_end(line)
