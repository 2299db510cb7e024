"""The port of viser: private, quiet, and released afterwards."""

from __future__ import annotations

import socket
from collections.abc import Iterator

import pytest
import requests
import websockets.asyncio.server as library
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from app.scene3d import viser_host as host_module
from app.scene3d.viser_host import HEADER, ViserHost
from tests.app.scene3d.scene3d_client import MAX_WAIT_S, PROTOCOL, is_closed
from tests.waiting import wait_until
from tsr_engine.errors import StorageError


@pytest.fixture(scope="module")
def host() -> Iterator[ViserHost]:
    made = ViserHost("test")
    yield made
    made.stop()


@pytest.mark.parametrize("headers", [{}, {HEADER: ""}, {HEADER: "guess"}, {"Authorization": "Bearer guess"}])
def test_page_and_scene_need_the_secret(host: ViserHost, headers: dict[str, str]) -> None:
    answer = requests.get(f"http://127.0.0.1:{host.port}/", headers=headers, timeout=MAX_WAIT_S)
    assert answer.status_code == 403
    assert "viser" not in answer.text.lower()
    with pytest.raises(InvalidStatus):
        connect(f"ws://127.0.0.1:{host.port}/", subprotocols=[PROTOCOL], additional_headers=headers, proxy=None)


def test_the_secret_opens_it(host: ViserHost) -> None:
    headers = {HEADER: host.secret}
    address = f"ws://127.0.0.1:{host.port}/"
    with connect(address, subprotocols=[PROTOCOL], additional_headers=headers, proxy=None) as line:
        assert line.recv(timeout=MAX_WAIT_S)


def test_it_listens_on_loopback_only(host: ViserHost) -> None:
    assert host.server.get_host() == "127.0.0.1"
    own = {found[4][0] for found in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}
    for address in own - {"127.0.0.1"}:
        if address.startswith("127."):
            continue
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection((address, host.port), timeout=1)


def test_no_tunnel_is_opened(host: ViserHost) -> None:
    assert host.server.request_share_url() is None


def test_other_viser_servers_and_output_are_unchanged(capsys: pytest.CaptureFixture[str]) -> None:
    import rich

    before = library.serve, rich.print
    made = ViserHost("quiet")
    port = made.port
    made.stop()
    made.stop()
    assert (library.serve, rich.print) == before
    assert capsys.readouterr().out == ""
    wait_until(lambda: is_closed(port))


def test_a_viser_without_access_control_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    ports = []

    def open_to_all(port: int) -> bool:
        ports.append(port)
        return False

    monkeypatch.setattr(host_module, "refuses_strangers", open_to_all)
    with pytest.raises(StorageError, match="everybody"):
        ViserHost("open")
    wait_until(lambda: is_closed(ports[0]))
