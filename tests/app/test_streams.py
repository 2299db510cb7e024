"""The event stream over real connections: no event is missed or repeated, and the stream never blocks the server."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
import requests
from sqlalchemy.exc import OperationalError

from app.events import EventBus
from tests.app.threaded_server import ThreadedServer, serve_in_thread
from tests.app.toy_server import SECRET, Server
from tests.waiting import time_limit

AUTHORISED = {"Authorization": f"Bearer {SECRET}"}


@pytest.fixture
def live_server(tmp_path: Path) -> Iterator[ThreadedServer]:
    """A server on a port."""
    with serve_in_thread(Server(tmp_path / "home")) as made:
        yield made


def publish(live_server: ThreadedServer, *numbers: int) -> None:
    context = live_server.server.context
    for number in numbers:
        with context.database.write() as session:
            context.events.publish(session, "test", "subject", {"number": number})


class EventStream:
    """One open stream."""

    def __init__(self, live_server: ThreadedServer, last: int | None = None) -> None:
        headers = AUTHORISED if last is None else {**AUTHORISED, "Last-Event-ID": str(last)}
        self.answer = requests.get(live_server.url + "/api/events", headers=headers, stream=True, timeout=15)
        assert self.answer.status_code == 200
        assert self.answer.headers["content-type"].startswith("text/event-stream")
        assert "content-encoding" not in self.answer.headers, "a compressed stream arrives late"
        self.lines = self.answer.iter_lines(chunk_size=None, decode_unicode=True)

    def next(self) -> tuple[str, int, Any]:
        """Kind, number and data of the next event.

        Raises:
            StopIteration: the stream ended.
        """
        found: dict[str, str] = {}
        for line in self.lines:
            if not line and "data" in found:
                return found["event"], int(found["id"]), json.loads(found["data"])
            name, _, value = line.partition(": ")
            found[name] = value
        raise StopIteration

    def close(self) -> None:
        """Drop the connection."""
        self.answer.close()


def test_a_page_receives_later_commits(live_server: ThreadedServer) -> None:
    publish(live_server, 1, 2)
    with closing(EventStream(live_server)) as page:
        kind, seq, data = page.next()
        assert (kind, data) == ("hello", {"seq": seq})
        publish(live_server, 3)
        kind, number, data = page.next()
        assert (kind, data["kind"], data["subject"], data["data"]) == ("change", "test", "subject", {"number": 3})
        assert number == data["seq"] > seq


def test_three_heartbeats_come_before_a_page_counts_its_connection_as_lost(live_server: ThreadedServer) -> None:
    """It does so after 12 s (``static/js/api/events.js``)."""
    with closing(EventStream(live_server)) as page:
        page.next()
        began = time.monotonic()
        assert next(line for line in page.lines if line.startswith(":")) == ": still here"
        assert time.monotonic() - began < 12 / 2


def test_a_stream_ends_cleanly_when_the_database_is_lost(
    live_server: ThreadedServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def has_access(_identity: object) -> bool:
        raise OperationalError("SELECT 1", {}, ConnectionError("the network is gone"))

    monkeypatch.setattr(live_server.server.context.access, "has_access", has_access)
    with closing(EventStream(live_server)) as page:
        assert page.next()[0] == "hello"
        assert [line for line in page.lines if line] == [], "an error would break the connection"


def test_reconnecting_loses_and_repeats_no_event(live_server: ThreadedServer) -> None:
    """Writers continue while the page drops its connection again and again at varying times."""
    total, writers = 300, 3
    first = EventStream(live_server)
    last = first.next()[1]

    def write(part: int) -> None:
        publish(live_server, *range(part, total, writers))

    threads = [threading.Thread(target=write, args=(part,)) for part in range(writers)]
    for thread in threads:
        thread.start()
    heard: list[int] = []
    numbers: list[int] = []
    page, connections = first, 1
    while len(heard) < total:
        for _ in range(1 + connections % 23):
            kind, seq, data = page.next()
            assert kind in ("hello", "change")
            if kind == "change":
                heard.append(data["data"]["number"])
                numbers.append(seq)
                last = seq
            if len(heard) == total:
                break
        page.close()
        page, connections = EventStream(live_server, last), connections + 1
    page.close()
    for thread in threads:
        thread.join()
    assert connections > 10
    assert sorted(heard) == list(range(total))
    assert numbers == sorted(set(numbers))


def test_a_page_that_is_too_far_behind_is_reset(live_server: ThreadedServer, monkeypatch: pytest.MonkeyPatch) -> None:
    publish(live_server, *range(30))
    context = live_server.server.context
    monkeypatch.setattr(EventBus, "max_events", 10)
    with context.database.write() as session:
        context.events.prune(session)
        newest = context.events.newest(session)
    with closing(EventStream(live_server, 3)) as page:
        assert page.next() == ("reset", newest, {})
        assert page.next()[0] == "hello"
        publish(live_server, 99)
        assert page.next()[2]["data"] == {"number": 99}
    with closing(EventStream(live_server, newest - 5)) as page:  # still stored: continues without a reset
        assert page.next()[0] == "hello"
        assert [page.next()[2]["data"]["number"] for _ in range(6)] == [25, 26, 27, 28, 29, 99]
    with closing(EventStream(live_server, newest + 1000)) as page:  # a number of another database
        assert page.next()[0] == "reset"


@pytest.mark.parametrize("last", ["x", "-1", "1.5", "9" * 19, "1e3", "٣"])
def test_an_invalid_event_id_is_refused(live_server: ThreadedServer, last: str) -> None:
    answer = requests.get(live_server.url + "/api/events", params={"after": last}, headers=AUTHORISED, timeout=30)
    assert answer.status_code == 422
    assert answer.json()["error"]["field"] == "last-event-id"


def test_open_streams_do_not_delay_shutdown(tmp_path: Path) -> None:
    with serve_in_thread(Server(tmp_path / "home")) as at:
        pages = [EventStream(at) for _ in range(20)]
        for page in pages:
            page.next()
        assert at.stop() < time_limit(3)
        for page in pages:
            with pytest.raises(StopIteration):
                page.next()
            page.close()


def test_a_page_that_does_not_read_blocks_nobody(live_server: ThreadedServer) -> None:
    with closing(EventStream(live_server)) as asleep, closing(EventStream(live_server)) as awake:
        awake.next()
        context = live_server.server.context
        for _ in range(4):
            with context.database.write() as session:
                for _ in range(100):
                    context.events.publish(session, "test", "s", {"text": "x" * 10_000})
        publish(live_server, 7)
        while (event := awake.next())[2]["data"] != {"number": 7}:
            pass
        assert requests.get(live_server.url + "/api/videos", headers=AUTHORISED, timeout=30).status_code == 200
        assert asleep.next()[0] == "hello"
        assert event[0] == "change"
