"""Everything that a running server is made of; hangs on the application, never on a module."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, cast

from fastapi import Depends, Request

from app.catalogue import Pictograms
from app.compare.service import CompareService
from app.edits.service import EditService
from app.events import EventBus
from app.evidence.service import EvidenceService
from app.jobs.queue import JobQueue
from app.runs.service import RunService
from app.security.tokens import Tokens, home_token
from app.settings import Settings
from app.storage.database import Database
from app.truths.service import TruthService
from app.videos.frames import FrameService
from app.videos.service import VideoService
from app.whatif.service import WhatIfService

__all__ = ["Context", "ContextDep", "build_context"]


@dataclass(frozen=True, slots=True)
class Context:
    """The parts of one server."""

    settings: Settings
    database: Database
    tokens: Tokens
    events: EventBus
    jobs: JobQueue
    videos: VideoService
    frames: FrameService
    runs: RunService
    evidence: EvidenceService
    edits: EditService
    truths: TruthService
    whatif: WhatIfService
    compare: CompareService
    pictograms: Pictograms

    def close(self) -> None:
        """Release files, threads and connections."""
        self.frames.close()
        self.evidence.close()
        self.database.close()


def build_context(settings: Settings) -> Context:
    """Make the parts; the database is brought up to date on the way.

    Raises:
        StorageError: the data folder or the database cannot be used.
    """
    settings.home.mkdir(parents=True, exist_ok=True)
    tokens = Tokens(settings.token or home_token(settings.home))
    database = Database(settings.database)
    database.migrate(settings.home / "backups")
    events = EventBus()
    jobs = JobQueue(events)
    videos = VideoService(settings, database, events, jobs)
    evidence = EvidenceService(settings, database)
    edits = EditService(database, events, evidence)
    truths = TruthService(database)
    return Context(
        settings=settings,
        database=database,
        tokens=tokens,
        events=events,
        jobs=jobs,
        videos=videos,
        frames=FrameService(settings, database),
        runs=RunService(settings, database, events, jobs),
        evidence=evidence,
        edits=edits,
        truths=truths,
        whatif=WhatIfService(database, events, jobs),
        compare=CompareService(database, evidence, edits, truths),
        pictograms=Pictograms(),
    )


def _context(request: Request) -> Context:
    return cast(Context, request.app.state.context)


ContextDep = Annotated[Context, Depends(_context)]
"""A route's parameter of this type is the server's context."""
