"""Connections that send nothing, half a request, or an ambiguous request (findings F5, F11)."""

from __future__ import annotations

import json
import re
import resource
import socket
import time
from collections.abc import Iterator

import pytest
import requests

from app.security.connections import ConnectionLimits
from tests.app.threaded_server import ThreadedServer, serve_in_thread
from tests.app.toy_server import SECRET, Server
from tests.waiting import time_limit

HEAD_TIMEOUT_S = 0.5
"""Deadline for heads in these tests, seconds."""
MAX_CONNECTIONS = 30
AUTHORISED = {"Authorization": f"Bearer {SECRET}"}
POST = b"POST /api/session/links HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer " + SECRET.encode() + b"\r\n"


@pytest.fixture(scope="module")
def live_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ThreadedServer]:
    """A server with short deadlines and few connections."""
    server = Server(tmp_path_factory.mktemp("wire") / "home")
    with serve_in_thread(server, ConnectionLimits(MAX_CONNECTIONS, HEAD_TIMEOUT_S)) as made:
        yield made


def open_at(live_server: ThreadedServer) -> socket.socket:
    found = socket.create_connection(("127.0.0.1", live_server.port), timeout=time_limit(5))
    found.settimeout(time_limit(5))
    return found


def answer_to(live_server: ThreadedServer, request: bytes) -> bytes:
    """Send a request; returns all bytes until the server closes the connection."""
    with open_at(live_server) as one:
        one.sendall(request)
        answer = b""
        try:
            while piece := one.recv(65536):
                answer += piece
        except ConnectionResetError:
            pass
        return answer


def send_slowly(one: socket.socket) -> None:
    """Send a byte now and then, for much longer than the deadline."""
    began = time.monotonic()
    while time.monotonic() - began < time_limit(10 * HEAD_TIMEOUT_S):
        one.sendall(b"G")
        time.sleep(HEAD_TIMEOUT_S / 10)


def answers(live_server: ThreadedServer) -> bool:
    return requests.get(live_server.url + "/api/formats", headers=AUTHORISED, timeout=time_limit(2)).status_code == 200


BAD = {
    "length and coding": POST + b"Content-Length: 4\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
    "coding and length": POST + b"Transfer-Encoding: chunked\r\nContent-Length: 4\r\n\r\n0\r\n\r\n",
    "two lengths": POST + b"Content-Length: 0\r\ncontent-length: 0\r\n\r\n",
    "two lengths in one": POST + b"Content-Length: 0, 0\r\n\r\n",
    "other length": POST + b"Content-Length: +1\r\n\r\nx",
    "coding in 1.0": POST.replace(b"1.1", b"1.0") + b"Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
    "other coding": POST + b"Transfer-Encoding: chunked, identity\r\n\r\n0\r\n\r\n",
    "bare LF": POST.replace(b"\r\n", b"\n") + b"\n",
    "one bare LF": POST + b"X-One: 1\nX-Two: 2\r\n\r\n",
    "bare LF at the end": POST + b"Content-Length: 0\r\n\n",
    "folded": POST + b"X-One: 1\r\n  and on\r\n\r\n",
    "folded by a tab": POST + b"X-One: 1\r\n\tand on\r\n\r\n",
    "space before the colon": POST + b"Content-Length : 0\r\n\r\n",
    "CR in a header": POST + b"X-One: 1\rX-Two: 2\r\n\r\n",
    "NUL in a header": POST + b"X-One: 1\0\r\n\r\n",
    "no name": POST + b": 1\r\n\r\n",
    "two spaces": b"GET  /api/formats HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
    "no version": b"GET /api/formats\r\nHost: 127.0.0.1\r\n\r\n",
    "TLS": b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
}
CHUNKS = {
    "negative": b"-5\r\nhello\r\n0\r\n\r\n",
    "0x": b"0x5\r\nhello\r\n0\r\n\r\n",
    "plus": b"+5\r\nhello\r\n0\r\n\r\n",
    "underscore": b"1_0\r\n0123456789abcdef\r\n0\r\n\r\n",
    "space": b"5 \r\nhello\r\n0\r\n\r\n",
    "empty": b"\r\nhello\r\n0\r\n\r\n",
    "too long": b"f" * 17 + b"\r\nhello\r\n0\r\n\r\n",
    "bare LF after the size": b"5\nhello\r\n0\r\n\r\n",
    "bare LF in an extension": b"5;a=\nb\r\nhello\r\n0\r\n\r\n",
    "longer than it says": b"3\r\nhello\r\n0\r\n\r\n",
    "bare LF in a trailer": b"5\r\nhello\r\n0\r\nX: 1\n\r\n",
    "length in a trailer": b"0\r\nContent-Length: 1\r\nTransfer-Encoding: chunked\r\n\r\n",
}


@pytest.mark.parametrize("request_", BAD.values(), ids=BAD)
def test_an_ambiguous_head_is_refused(live_server: ThreadedServer, request_: bytes) -> None:
    answer = answer_to(live_server, request_ + b"GET /api/formats HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
    head, _, body = answer.partition(b"\r\n\r\n")
    assert head.startswith(b"HTTP/1.1 400 "), answer
    assert b"connection: close" in head.lower()
    assert json.loads(body)["error"]["code"] == "bad_request", "nothing but the refusal comes back"


@pytest.mark.parametrize("body", CHUNKS.values(), ids=CHUNKS)
def test_a_bad_chunk_is_refused(live_server: ThreadedServer, body: bytes) -> None:
    answer = answer_to(
        live_server, POST.replace(b"/session/links", b"/exports") + b"Transfer-Encoding: chunked\r\n\r\n" + body
    )
    assert answer.startswith(b"HTTP/1.1 400 "), answer
    assert answer.count(b"HTTP/1.1 ") == 1


def test_a_valid_request_is_answered(live_server: ThreadedServer) -> None:
    request = b"GET /api/formats HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer " + SECRET.encode() + b"\r\n"
    both = POST + b"Transfer-Encoding: chunked\r\n\r\n5;a=b\r\nhello\r\n0\r\nX: 1\r\n\r\n"
    both += request + b"Connection: close\r\n\r\n"
    assert re.findall(rb"HTTP/1.1 (\d+) ", answer_to(live_server, both)) == [b"201", b"200"]


@pytest.mark.parametrize("said", [b"", b"G", POST, POST + b"Content-Length: 9\r\n"])
def test_an_unfinished_head_has_a_deadline(live_server: ThreadedServer, said: bytes) -> None:
    with open_at(live_server) as one:
        began = time.monotonic()
        one.sendall(said)
        assert one.recv(100) == b""
        assert HEAD_TIMEOUT_S / 2 < time.monotonic() - began < time_limit(3 * HEAD_TIMEOUT_S)


def test_a_head_sent_byte_by_byte_has_the_same_deadline(live_server: ThreadedServer) -> None:
    with open_at(live_server) as one, pytest.raises(ConnectionError):
        send_slowly(one)


def test_a_second_head_has_a_deadline_too(live_server: ThreadedServer) -> None:
    with open_at(live_server) as one:
        one.sendall(POST + b"Content-Length: 0\r\n\r\n")
        assert b" 201 " in one.recv(65536)
        one.sendall(POST)
        while piece := one.recv(65536):
            assert b"400" not in piece


def test_an_unwanted_body_has_a_deadline(live_server: ThreadedServer) -> None:
    with open_at(live_server) as one:
        one.sendall(b"POST /api/exports HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1000\r\n\r\n")
        assert b" 401 " in one.recv(65536)
        with pytest.raises(ConnectionError):
            send_slowly(one)


def test_silent_connections_block_nobody(live_server: ThreadedServer) -> None:
    held = []
    try:
        for _ in range(4 * MAX_CONNECTIONS):
            one = open_at(live_server)
            one.sendall(b"GET / HTTP/1.1\r\n")
            held.append(one)
            if len(held) % MAX_CONNECTIONS == 0:
                assert answers(live_server)
        assert len(live_server.uvicorn.server_state.connections) <= MAX_CONNECTIONS
        assert answers(live_server)
    finally:
        for one in held:
            one.close()


def test_the_connection_limit_leaves_descriptors_for_files() -> None:
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    try:
        door = ConnectionLimits()
        soft = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
        assert 0 < door.max_connections <= min(1000, soft // 2)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, before)
    assert HEAD_TIMEOUT_S < ConnectionLimits().head <= 10
