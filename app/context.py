"""The parts of a running server, attached to the application, never to a module."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import partial
from typing import Annotated, cast

from fastapi import Depends, Request

from app.bundles.importing import BundleImports
from app.bundles.service import BundleService
from app.compare.service import CompareService
from app.edits.bulk import BulkEdits
from app.edits.log_store import LogStore
from app.edits.service import EditService
from app.events import EventBus
from app.evidence.pixels import RunPixels
from app.evidence.service import EvidenceService
from app.exchange.imports import ImportService
from app.exchange.running_imports import RunningImports
from app.exchange.sandboxed_imports import SandboxedImports
from app.exchange.service import ExportService
from app.exchange.take_over import TakeOverService
from app.file_sync import FileSync
from app.files.shared import shared_files
from app.follows.service import FollowService
from app.ground_truths.service import GroundTruthService
from app.job_kinds import KINDS
from app.jobs.queue import JobQueue
from app.labels.pictures import Pictograms
from app.labels.service import LabelService
from app.outputs.service import OutputService
from app.people.activity import ActivityService
from app.people.assignments import AssignmentService
from app.people.directory import Directory
from app.people.second_opinion import SecondOpinionService
from app.people.service import PeopleService
from app.recordings.service import RecordingService
from app.recordings.viewer import ViewerFiles
from app.runs.service import RunService
from app.sandbox.sandboxes import Sandboxes
from app.scene3d.export_request import SceneService
from app.scene3d.prior import find_prior
from app.scene3d.service import Scene3dService
from app.search.actions import SearchActions
from app.search.index import SearchIndex
from app.search.matching import LabelledVideos
from app.security.access import Access
from app.security.proxies import Proxies
from app.security.tokens import Tokens, home_token
from app.settings import Settings
from app.storage.database import Database
from app.storage.identity import open_database
from app.storage.misplaced_database import fetch_misplaced
from app.storage.servers import Servers
from app.training.service import TrainingService
from app.videos.decoding import SandboxedDecoder
from app.videos.frames import FrameService
from app.videos.service import VideoService
from app.videos.uploads import Uploads
from app.whatif.service import WhatIfService
from tsr_engine.errors import StorageError
from tsr_engine.extras import require_extra

_log = logging.getLogger("tsr.server")


@dataclass(frozen=True, slots=True)
class Context:
    """The parts of one server."""

    settings: Settings
    sandboxes: Sandboxes
    database: Database
    servers: Servers
    tokens: Tokens
    people: PeopleService
    assignments: AssignmentService
    activity: ActivityService
    second_opinions: SecondOpinionService
    directory: Directory
    access: Access
    events: EventBus
    file_sync: FileSync | None
    jobs: JobQueue
    uploads: Uploads
    videos: VideoService
    frames: FrameService
    runs: RunService
    evidence: EvidenceService
    pixels: RunPixels
    edits: EditService
    bulk_edits: BulkEdits
    ground_truths: GroundTruthService
    take_overs: TakeOverService
    whatif: WhatIfService
    follows: FollowService
    compare: CompareService
    outputs: OutputService
    training: TrainingService
    exports: ExportService
    imports: ImportService
    sandboxed_imports: SandboxedImports
    running_imports: RunningImports
    recordings: RecordingService
    viewer: ViewerFiles
    scene3d: Scene3dService
    scenes: SceneService
    bundles: BundleService
    bundle_imports: BundleImports
    labels: LabelService
    labelled_videos: LabelledVideos
    pictograms: Pictograms
    search: SearchIndex
    search_actions: SearchActions

    def sign_in_path(self) -> str:
        """Return the path that opens the page: a new one-time link or, with people, the sign-in page."""
        return f"/login/{self.tokens.new_link()}" if self.directory.is_empty() else "/"

    def close(self) -> None:
        """Release files, threads, connections and processes."""
        self.sandboxes.close()
        self.scene3d.close()
        self.frames.close()
        self.pixels.close()
        self.evidence.close()
        self.servers.unregister()
        self.database.close()


def build_context(settings: Settings) -> Context:
    """Build the parts of a server; this also migrates the database.

    Raises:
        StorageError: the data folder or the database cannot be used.
        MissingExtra: the executor in the settings needs an extra that is not installed.
    """
    if settings.executor != "local":
        require_extra("ray")
    settings.home.mkdir(parents=True, exist_ok=True)
    fetch_misplaced(settings)
    files = shared_files(settings)
    if files is not None:
        files.is_blocking = False
        if (away := files.prepare()) is not None:
            _log.warning("%s", away)
    sandboxes = Sandboxes()
    tokens = Tokens(settings.token or home_token(settings.home))
    database = open_database(settings)
    database.migrate(settings.home / "backups")
    events = EventBus()
    directory = Directory(database)
    directory.is_empty()
    jobs = JobQueue(events, KINDS)
    uploads = Uploads(settings.home, database)
    servers = Servers(database, settings.home)
    try:
        servers.register()
    except StorageError:
        database.close()
        raise
    servers.store_shared_address(settings.files or "")
    videos = VideoService(settings, database, events, jobs, uploads, servers)
    evidence = EvidenceService(settings, database)
    log = LogStore(database, events, evidence, settings)
    edits, bulk_edits = EditService(log), BulkEdits(log)
    search = SearchIndex(database, evidence)
    ground_truths = GroundTruthService(database)
    imports = ImportService(settings, database, events, bulk_edits, ground_truths)
    frames = FrameService(settings, database, partial(SandboxedDecoder, sandboxes, memory_mb=settings.worker_memory_mb))
    outputs = OutputService(settings, database, events, jobs)
    return Context(
        settings=settings,
        sandboxes=sandboxes,
        database=database,
        servers=servers,
        tokens=tokens,
        people=PeopleService(database, events),
        assignments=AssignmentService(database, events),
        activity=ActivityService(database),
        second_opinions=SecondOpinionService(database, events),
        directory=directory,
        access=Access(tokens, directory, Proxies(settings.trusted_proxies, settings.proxy_header)),
        events=events,
        file_sync=None if files is None else FileSync(settings, database, events, files),
        jobs=jobs,
        uploads=uploads,
        videos=videos,
        frames=frames,
        runs=RunService(settings, database, events, jobs, servers),
        evidence=evidence,
        pixels=RunPixels(settings, database, evidence),
        edits=edits,
        bulk_edits=bulk_edits,
        ground_truths=ground_truths,
        take_overs=TakeOverService(settings, database, bulk_edits, ground_truths),
        whatif=WhatIfService(database, events, jobs),
        follows=FollowService(database, jobs),
        compare=CompareService(database, evidence, ground_truths),
        outputs=outputs,
        training=TrainingService(settings, database, events, jobs),
        exports=ExportService(settings, database, outputs),
        imports=imports,
        sandboxed_imports=SandboxedImports(settings, imports, sandboxes),
        running_imports=RunningImports(),
        recordings=RecordingService(database, evidence, outputs),
        viewer=ViewerFiles(settings.home),
        scene3d=Scene3dService(database, events, evidence, frames, lambda run: find_prior(settings, database, run)),
        scenes=SceneService(database, evidence, outputs),
        bundles=BundleService(database, evidence, outputs),
        bundle_imports=BundleImports(settings, database, events, jobs, uploads, bulk_edits, sandboxes),
        labels=LabelService(database, events),
        labelled_videos=LabelledVideos(database, search),
        pictograms=Pictograms(database),
        search=search,
        search_actions=SearchActions(database, edits, bulk_edits, search),
    )


async def _context(request: Request) -> Context:  # async: a plain function would run in a thread
    return cast(Context, request.app.state.context)


ContextDep = Annotated[Context, Depends(_context)]
"""A route's parameter of this type is the server's context."""
