"""Background parts of the server: the supervisor of the workers and the stream of events."""

from __future__ import annotations

import asyncio
import threading
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import partial

from sqlalchemy.exc import SQLAlchemyError

from app.context import Context
from app.file_sync import PROBE_INTERVAL_S, FileSync
from app.follows.service import LEASE_S
from app.jobs.supervisor import Supervisor
from app.outputs.file_moves import sweep as sweep_file_moves
from app.search.index import SearchIndex
from app.storage.disk_space import shortage
from app.storage.servers import assign_local_files
from app.streaming import EventStream
from tsr_engine.periodic import call_periodically

_SYNC_INTERVAL_S = 1.0
"""Seconds between searches for finished files that are not in the shared files yet."""
_SEARCH_INTERVAL_S = 1.0
"""Seconds between updates of the search's tables."""
_ANALYZE_INTERVAL_S = 3600.0
"""Seconds between two runs of SQLite's ``ANALYZE``."""


@dataclass(slots=True)
class Running:
    """The parts that must be stopped."""

    supervisor: Supervisor | None
    stream: EventStream
    warmer: threading.Thread
    search: SearchIndex
    file_sync: FileSync | None
    periodic_tasks: ExitStack


def start(context: Context) -> Running:
    """Start the background parts; called on the server's event loop."""
    periodic_tasks = ExitStack()
    periodic_tasks.enter_context(context.servers.heartbeat())
    context.uploads.update_paths()
    assign_local_files(context.database, context.settings.home)
    if context.settings.sample:
        context.videos.add_samples(context.ground_truths)
    context.uploads.clean_parts()
    context.outputs.sweep()
    context.imports.sweep()
    context.runs.sweep()
    sweep_file_moves(context.settings.home, context.database)
    file_sync = context.file_sync

    def problem() -> str | None:
        return shortage(context.settings.home) or (None if file_sync is None else file_sync.problem)

    stream = EventStream(
        context.database, context.events, problem, context.directory.invalidate, context.runs.with_unstored_ends
    )
    supervisor = None
    if context.settings.workers:
        supervisor = Supervisor(context.settings, context.database, context.jobs, lambda: stream.pages > 0)
        supervisor.start()
    warmer = threading.Thread(target=context.evidence.warm, name="tsr-warm", daemon=True)
    warmer.start()
    stream.start()
    periodic_tasks.enter_context(call_periodically("tsr-follows", LEASE_S / 4, context.follows.sweep))
    if file_sync is not None:
        periodic_tasks.enter_context(call_periodically("tsr-sending", _SYNC_INTERVAL_S, file_sync.tick))
        periodic_tasks.enter_context(call_periodically("tsr-probing", PROBE_INTERVAL_S, file_sync.probe))
    periodic_tasks.enter_context(call_periodically("tsr-search", _SEARCH_INTERVAL_S, context.search.tick))
    _analyze(context)
    periodic_tasks.enter_context(call_periodically("tsr-analyze", _ANALYZE_INTERVAL_S, partial(_analyze, context)))
    return Running(supervisor, stream, warmer, context.search, file_sync, periodic_tasks)


def _analyze(context: Context) -> None:
    with suppress(SQLAlchemyError):  # the disk is full or slow: tried again later
        context.database.analyze()


async def stop(running: Running) -> None:
    """Stop the background parts, event streams first: an open page must not delay the shutdown."""
    running.search.stop()
    if running.file_sync is not None:
        running.file_sync.stop()
    await running.stream.stop()
    if running.supervisor is not None:
        await asyncio.to_thread(running.supervisor.stop)
    await asyncio.to_thread(running.warmer.join)
    await asyncio.to_thread(running.periodic_tasks.close)
