"""Everything that a running server is made of; hangs on the application, never on a module."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Annotated, cast

from fastapi import Depends, Request

from app.bundles.importing import BundleImports
from app.bundles.service import BundleService
from app.cages.cage import Cages
from app.compare.service import CompareService
from app.edits.service import EditService
from app.events import EventBus
from app.evidence.service import EvidenceService
from app.exchange.caged import CagedImports
from app.exchange.imports import ImportService
from app.exchange.service import ExportService
from app.follows.service import FollowService
from app.ground_truths.service import GroundTruthService
from app.jobs.queue import JobQueue
from app.kinds import KINDS
from app.labels.pictures import Pictograms
from app.labels.service import LabelService
from app.outputs.service import OutputService
from app.recordings.service import RecordingService
from app.recordings.viewer import ViewerFiles
from app.runs.service import RunService
from app.scene3d.ordering import SceneService
from app.scene3d.prior import find_prior
from app.scene3d.service import Scene3dService
from app.search.actions import SearchActions
from app.search.index import SearchIndex
from app.security.tokens import Tokens, home_token
from app.settings import Settings
from app.storage.database import Database
from app.storage.identity import server_of
from app.storage.misplaced import fetch_misplaced
from app.storage.places import Servers
from app.training.service import TrainingService
from app.videos.decoding import CagedDecoder
from app.videos.frames import FrameService
from app.videos.service import VideoService
from app.videos.uploads import Uploads
from app.whatif.service import WhatIfService

__all__ = ["Context", "ContextDep", "build_context"]


@dataclass(frozen=True, slots=True)
class Context:
    """The parts of one server."""

    settings: Settings
    cages: Cages
    database: Database
    servers: Servers
    tokens: Tokens
    events: EventBus
    jobs: JobQueue
    uploads: Uploads
    videos: VideoService
    frames: FrameService
    runs: RunService
    evidence: EvidenceService
    edits: EditService
    ground_truths: GroundTruthService
    whatif: WhatIfService
    follows: FollowService
    compare: CompareService
    outputs: OutputService
    training: TrainingService
    exports: ExportService
    imports: ImportService
    caged_imports: CagedImports
    recordings: RecordingService
    viewer: ViewerFiles
    scene3d: Scene3dService
    scenes: SceneService
    bundles: BundleService
    bundle_imports: BundleImports
    labels: LabelService
    pictograms: Pictograms
    search: SearchIndex
    search_actions: SearchActions

    def close(self) -> None:
        """Release files, threads, connections and processes."""
        self.cages.close()
        self.scene3d.close()
        self.frames.close()
        self.evidence.close()
        self.database.close()


def build_context(settings: Settings) -> Context:
    """Make the parts; the database is brought up to date on the way.

    Raises:
        StorageError: the data folder or the database cannot be used.
    """
    settings.home.mkdir(parents=True, exist_ok=True)
    fetch_misplaced(settings)
    cages = Cages()
    tokens = Tokens(settings.token or home_token(settings.home))
    database = Database(settings.database, server_of(settings))
    database.migrate(settings.home / "backups")
    events = EventBus()
    jobs = JobQueue(events, KINDS)
    uploads = Uploads(settings.home, database)
    servers = Servers(database, settings.home)
    videos = VideoService(settings, database, events, jobs, uploads, servers)
    evidence = EvidenceService(settings, database)
    edits = EditService(database, events, evidence, settings)
    search = SearchIndex(database, evidence)
    ground_truths = GroundTruthService(database)
    imports = ImportService(settings, database, events, edits, ground_truths)
    frames = FrameService(settings, database, partial(CagedDecoder, cages, memory_mb=settings.worker_memory_mb))
    outputs = OutputService(settings, database, events, jobs)
    return Context(
        settings=settings,
        cages=cages,
        database=database,
        servers=servers,
        tokens=tokens,
        events=events,
        jobs=jobs,
        uploads=uploads,
        videos=videos,
        frames=frames,
        runs=RunService(settings, database, events, jobs, servers),
        evidence=evidence,
        edits=edits,
        ground_truths=ground_truths,
        whatif=WhatIfService(database, events, jobs),
        follows=FollowService(database, jobs),
        compare=CompareService(database, evidence, edits, ground_truths),
        outputs=outputs,
        training=TrainingService(settings, database, events, jobs),
        exports=ExportService(settings, database, outputs),
        imports=imports,
        caged_imports=CagedImports(settings, imports, cages),
        recordings=RecordingService(database, evidence, outputs),
        viewer=ViewerFiles(settings.home),
        scene3d=Scene3dService(
            database, events, evidence, frames, edits, lambda run: find_prior(settings, database, run)
        ),
        scenes=SceneService(database, evidence, outputs),
        bundles=BundleService(database, evidence, outputs),
        bundle_imports=BundleImports(settings, database, events, jobs, uploads, edits, cages),
        labels=LabelService(database, events),
        pictograms=Pictograms(database),
        search=search,
        search_actions=SearchActions(database, edits, search),
    )


def _context(request: Request) -> Context:
    return cast(Context, request.app.state.context)


ContextDep = Annotated[Context, Depends(_context)]
"""A route's parameter of this type is the server's context."""
