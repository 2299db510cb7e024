"""Events for open pages: one task reads the database for any number of pages."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence

from sqlalchemy.exc import SQLAlchemyError

from app.events import EventBus
from app.log_once import LogOnce
from app.runs.view import RunView
from app.storage.database import Database
from app.storage.models import Event

_READ_INTERVAL_S = 0.12
_HEARTBEAT_INTERVAL_S = 4.0
_MAX_WAITING = 2000
_DISK_CHECK_TURNS = 16
"""Turns between checks of the disk."""
_PEOPLE = "people"
"""Queue entry that announces a change of accounts: the page's access is checked again."""
_log = logging.getLogger("tsr.events")


class EventStream:
    """Sends the numbered stream to all pages.

    A page sends the last number it has seen and gets everything after it, without gaps or duplicates. A page that is
    too far behind, or too slow, is asked to reload everything (``reset``).

    A full disk (``storage``), and the runs whose end cannot be stored (``unstored``), are reported outside the numbered
    stream, which cannot be written then.

    Args:
        database: where the events are.
        events: the bus.
        shortage: returns a sentence while the disk is full; None: there is room.
        on_people: called when accounts have changed.
        unstored: returns the views of the runs whose end cannot be stored.
    """

    def __init__(
        self,
        database: Database,
        events: EventBus,
        shortage: Callable[[], str | None] = lambda: None,
        on_people: Callable[[], None] = lambda: None,
        unstored: Callable[[], Sequence[RunView]] = tuple,
    ) -> None:
        self._database = database
        self._events = events
        self._shortage = shortage
        self._on_people = on_people
        self._unstored = unstored
        self._full: str | None = None
        self._unstored_runs: list[str] = []
        self._pages: set[asyncio.Queue[str | None]] = set()
        self._seen = 0
        self._newest = database.polled(events.newest)
        self._task: asyncio.Task[None] | None = None
        self._turns = 0
        self._stopped = False

    @property
    def pages(self) -> int:
        """Number of open pages."""
        return len(self._pages)

    def start(self) -> None:
        """Start reading; needs a running event loop."""
        self._seen = self._newest()
        self._task = asyncio.get_running_loop().create_task(self._read())

    async def stop(self) -> None:
        """End all streams; safe to call again."""
        self._stopped = True
        task, self._task = self._task, None
        if task is not None:
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task
        for page in self._pages:
            page.put_nowait(None)

    async def follow(self, last: int | None, has_access: Callable[[], Awaitable[bool]]) -> AsyncIterator[str]:
        """Yield server-sent events after a number.

        Args:
            last: the number; unset: from now on.
            has_access: whether the listener still has access; called when accounts have changed and every few seconds.
                The stream ends when it returns false, and when the database is lost.
        """
        page: asyncio.Queue[str | None] = asyncio.Queue()
        try:
            # compare with the database: the reading task is up to one turn behind it
            missed, newest = await asyncio.to_thread(self._missed, last)
            seen = newest if last is None else last
            if missed is None or seen > newest:
                missed, seen = None, newest
                yield f"id: {seen}\nevent: reset\ndata: {{}}\n\n"
            self._pages.add(page)
            yield f'id: {seen}\nevent: hello\ndata: {{"seq": {seen}}}\n\n'
            for unnumbered in (*([] if self._full is None else [_storage(self._full)]), *self._unstored_runs):
                yield unnumbered
            for event in missed or ():
                if event.seq > seen:
                    seen = event.seq
                    yield _text(event)
            if seen < self._seen:
                for event in await asyncio.to_thread(self._range, seen):
                    if event.seq > seen:
                        seen = event.seq
                        yield _text(event)
            if not await has_access():  # accounts may have changed before the queue existed
                return
            while not self._stopped:
                try:
                    text = await asyncio.wait_for(page.get(), _HEARTBEAT_INTERVAL_S)
                except TimeoutError:
                    if not await has_access():
                        return
                    yield ": still here\n\n"
                    continue
                if text is None or (text == _PEOPLE and not await has_access()):
                    return
                is_new = not text.startswith("id: ") or int(text[4 : text.index("\n")]) > seen
                if is_new and text != _PEOPLE:
                    yield text
        except SQLAlchemyError:  # the page connects again, and continues after its last event
            return
        finally:
            self._pages.discard(page)

    def _missed(self, last: int | None) -> tuple[Sequence[Event] | None, int]:
        """Events after ``last`` (None: too many, or deleted) and the number of the newest."""
        with self._database.read() as session:
            newest, oldest = self._events.newest(session), self._events.oldest(session)
            if last is None:
                return (), newest
            if last and oldest and last < oldest - 1:
                return None, newest
            missed = self._events.after(session, last, _MAX_WAITING + 1)
            return (None if len(missed) > _MAX_WAITING else missed), newest

    def _range(self, seen: int) -> Sequence[Event]:
        with self._database.read() as session:
            return self._events.after(session, seen, _MAX_WAITING)

    def _unseen(self) -> Sequence[Event]:
        """Events that no page has got yet."""
        return self._range(self._seen) if self._newest() > self._seen else ()

    async def _read(self) -> None:
        log_once = LogOnce(_log, "Events cannot be read")
        while True:
            await asyncio.sleep(_READ_INTERVAL_S)
            try:
                found = await asyncio.to_thread(self._unseen)
                self._turns += 1
                if self._turns % _DISK_CHECK_TURNS == 1:
                    await self._check_disk()
                if self._turns % 2000 == 0:
                    await asyncio.to_thread(self._prune)
            except SQLAlchemyError as error:
                log_once.failed(error)
                await asyncio.sleep(1.0)
                continue
            log_once.recovered()
            for event in found:
                if event.kind == "people":
                    self._on_people()
                text = _text(event)
                self._seen = event.seq
                for page in self._pages:
                    if page.qsize() < _MAX_WAITING:
                        if event.kind == "people":
                            page.put_nowait(_PEOPLE)
                        page.put_nowait(text)
                    elif page.qsize() == _MAX_WAITING:
                        page.put_nowait(None)  # the page reconnects with its number and catches up, or resets

    async def _check_disk(self) -> None:
        """Notify the pages when the disk becomes full, when it has room again, and of ends that cannot be stored."""
        before, self._full = self._full, await asyncio.to_thread(self._shortage)
        if (before is None) != (self._full is None):
            for page in self._pages:
                page.put_nowait(_storage(self._full))
        runs = [_unstored(run) for run in await asyncio.to_thread(self._unstored)]
        new, self._unstored_runs = [text for text in runs if text not in self._unstored_runs], runs
        for page in self._pages:
            for text in new:
                page.put_nowait(text)

    def _prune(self) -> None:
        with self._database.write() as session:
            self._events.prune(session)


def _storage(text: str | None) -> str:
    return f"event: storage\ndata: {json.dumps({'text': text})}\n\n"


def _unstored(run: RunView) -> str:
    data = {"kind": "run", "subject": run.id, "data": run.model_dump(mode="json")}
    return f"event: unstored\ndata: {json.dumps(data, separators=(',', ':'))}\n\n"


def _text(event: Event) -> str:
    data = {"seq": event.seq, "kind": event.kind, "subject": event.subject, "data": event.data}
    return f"id: {event.seq}\nevent: change\ndata: {json.dumps(data, separators=(',', ':'))}\n\n"
