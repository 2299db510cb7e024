"""Background parts of the server: the supervisor of the workers and the stream of events."""

from __future__ import annotations

import asyncio
import threading
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import partial

from sqlalchemy.exc import SQLAlchemyError

from app.context import Context
from app.follows.service import LEASE
from app.jobs.supervisor import Supervisor
from app.outputs.placing import sweep as sweep_placing
from app.search.index import SearchIndex
from app.sending import Sending
from app.storage.places import adopt_files
from app.storage.room import shortage
from app.streaming import EventStream
from tsr_engine.periodic import call_periodically

__all__ = ["Running", "start", "stop"]

_SENDING = 1.0
"""Seconds between searches for finished files that are not in the shared files yet."""
_SEARCH = 1.0
"""Seconds between updates of the search's tables."""
_TIDY = 3600.0
"""Seconds between two runs of SQLite's ``ANALYZE``."""


@dataclass(slots=True)
class Running:
    """The parts that must be stopped."""

    supervisor: Supervisor | None
    stream: EventStream
    warmer: threading.Thread
    search: SearchIndex
    sending: Sending | None
    beating: ExitStack


def start(context: Context) -> Running:
    """Start the background parts; called on the server's event loop."""
    beating = ExitStack()
    beating.enter_context(context.servers.beating())
    context.uploads.follow_home()
    adopt_files(context.database, context.settings.home)
    if context.settings.sample:
        context.videos.add_samples(context.ground_truths)
    context.uploads.clean_parts()
    context.outputs.sweep()
    context.imports.sweep()
    context.runs.sweep()
    sweep_placing(context.settings.home, context.database)
    sending = context.sending

    def trouble() -> str | None:
        return shortage(context.settings.home) or (None if sending is None else sending.trouble)

    stream = EventStream(context.database, context.events, trouble, context.directory.forget)
    supervisor = None
    if context.settings.workers:
        supervisor = Supervisor(context.settings, context.database, context.jobs, lambda: stream.pages > 0)
        supervisor.start()
    warmer = threading.Thread(target=context.evidence.warm, name="tsr-warm", daemon=True)
    warmer.start()
    stream.start()
    beating.enter_context(call_periodically("tsr-follows", LEASE / 4, context.follows.sweep))
    if sending is not None:
        beating.enter_context(call_periodically("tsr-sending", _SENDING, sending.tick))
    beating.enter_context(call_periodically("tsr-search", _SEARCH, context.search.tick))
    _tidy(context)
    beating.enter_context(call_periodically("tsr-tidy", _TIDY, partial(_tidy, context)))
    return Running(supervisor, stream, warmer, context.search, sending, beating)


def _tidy(context: Context) -> None:
    with suppress(SQLAlchemyError):  # the disk is full or slow: tried again later
        context.database.tidy()


async def stop(running: Running) -> None:
    """Stop the background parts, event streams first: an open page must not delay the shutdown."""
    running.search.leave()
    if running.sending is not None:
        running.sending.leave()
    await running.stream.stop()
    if running.supervisor is not None:
        await asyncio.to_thread(running.supervisor.stop)
    await asyncio.to_thread(running.warmer.join)
    await asyncio.to_thread(running.beating.close)
