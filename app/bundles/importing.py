"""Imports a bundle into the library atomically: clip, run and corrections."""

from __future__ import annotations

import os
import uuid
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session, undefer

from app.body_model import Model
from app.bundles.corrections import read_corrections, relabelled_documents, shift_document
from app.edits.bulk import BulkEdits
from app.edits.documents import TrackDoc, engine_doc
from app.errors import ApiError, Busy, file_error
from app.events import EventBus
from app.jobs.queue import JobQueue
from app.labels.mapping import labels_of_model
from app.labels.store import default_key, newest
from app.outputs.file_moves import FileMoves, moving_files
from app.runs.focus import focus_of
from app.runs.parameters import as_setting, params_of
from app.runs.view import RunView, publish_run, run_view
from app.sandbox.limits import NICE, Limits
from app.sandbox.sandboxes import SandboxError, Sandboxes, SandboxesClosed
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Run, Video
from app.storage.servers import require_local
from app.videos.uploads import Uploads
from app.videos.view import VideoView, video_view
from tsr_engine.bundle.expectation import Expectation, read_expectation
from tsr_engine.bundle.judge import describe_expectation
from tsr_engine.bundle.layout import CORRECTIONS, EVIDENCE, EXPECTATION
from tsr_engine.bundle.manifest import Manifest
from tsr_engine.errors import ImportFormatError, ImportProblem, TsrError, UsageError
from tsr_engine.evidence.header import read_header
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.model import LabelSet
from tsr_engine.params import PRESETS, Params
from tsr_engine.params.aliases import current_sections

_COMPUTING = 900
"""Limit of computing time to check a bundle, seconds; lower for a short clip, see ``app.bundles.checking``."""
_WALL = 900.0
"""Limit of time to check a bundle, seconds."""


class ExpectedView(Model):
    """One expectation, and its result when the bundle was made."""

    id: str
    expected: str
    met: bool
    got: str


class BundleReportView(Model):
    """Contents of an imported bundle."""

    note: str
    video_name: str
    first: int
    stop: int
    offset: int
    """Frame of the original video that is the clip's frame 0."""
    frame: int
    """Frame of the clip to look at first: of the first expectation that failed, else the first frame that is judged."""
    track: str | None
    """Track to look at in that frame."""
    expected: list[ExpectedView]
    corrections: int
    other_pictures: int
    """Pictures that decode to other bits here than on the machine that made the bundle."""
    skipped: list[str]
    engine_version: str


class BundleImport(Model):
    """A bundle in the library."""

    video: VideoView
    run: RunView
    report: BundleReportView


class BundleImports:
    """Imports bundles into the library."""

    def __init__(
        self,
        settings: Settings,
        database: Database,
        events: EventBus,
        jobs: JobQueue,
        uploads: Uploads,
        edits: BulkEdits,
        sandboxes: Sandboxes,
    ) -> None:
        self._sandboxes = sandboxes
        self._settings = settings
        self._database = database
        self._events = events
        self._jobs = jobs
        self._uploads = uploads
        self._edits = edits

    def import_bundle(
        self, path: Path, folder: Path, author: str, stop: Callable[[], bool] = lambda: False
    ) -> BundleImport:
        """Check a bundle, then store all of it in one transaction.

        Args:
            path: the ZIP file.
            folder: in the data folder, empty; the caller removes it.
            author: author of the corrections.
            stop: returns whether the client has disconnected.

        Raises:
            Busy: the import was stopped, or the server ends.
            Invalid, TooLarge, Unsafe: the bundle breaks a rule; the message names the first one.
        """
        check_result = self._check(path, folder, stop)
        place = folder / "bundle"
        try:
            manifest = Manifest.read(place, path.name)
            documents, keys = read_corrections(place / CORRECTIONS)
            expectation = read_expectation(place / EXPECTATION)
        except ImportFormatError as error:
            raise _refused(str(error), error.kind) from None
        documents, missing_keys = relabelled_documents(documents, keys, self._labels(manifest.clip.sha256))
        frames, offset = manifest.frames, manifest.clip.offset
        spans = {int(track): (span[0], span[1]) for track, span in check_result["tracks"].items()}
        shifted = {doc.key: shift_document(doc, frames.start, frames.stop, offset, spans) for doc in documents}
        documents_in_clip = {key: doc for key, doc in shifted.items() if doc is not None}
        skipped = [
            f"The corrections of {key} lie outside of these frames." for key, doc in shifted.items() if doc is None
        ]
        skipped += [
            f"The label set here has no label '{key}', so tracks with it have no label now." for key in missing_keys
        ]
        got = {result.id: result for result in manifest.got}
        expected = [
            ExpectedView(
                id=each.id,
                expected=describe_expectation(each, expectation),
                met=got[each.id].met if each.id in got else False,
                got=got[each.id].text if each.id in got else "",
            )
            for each in expectation.expected
        ]
        frame, sign = _first_problem(expectation, expected, frames.first)
        report = BundleReportView(
            note=manifest.note,
            video_name=manifest.video.name,
            first=frames.first - offset,
            stop=frames.stop - offset,
            offset=offset,
            frame=frame - offset,
            track=sign if sign in {*documents_in_clip, *(f"m{track}" for track in spans)} else None,
            expected=expected,
            corrections=len(documents_in_clip),
            other_pictures=check_result["other_pictures"],
            skipped=skipped,
            engine_version=manifest.run.engine_version,
        )
        return self._store(manifest, place, folder, documents_in_clip, spans, report, author)

    def _labels(self, video_id: str) -> LabelSet:
        """The label set of the clip's video, or the library's if the video is new here."""
        with self._database.read() as session:
            video = session.get(Video, video_id)
            return newest(session, default_key(session) if video is None else video.label_set or default_key(session))

    def _check(self, path: Path, folder: Path, stop: Callable[[], bool]) -> JsonObject:
        """Check the bundle in a sandbox, so that a malicious one can only harm that process."""
        with path.open("rb") as stream:
            if not stream.read(4).startswith(b"PK"):
                raise _refused(
                    f"{path.name} is not a ZIP archive. Choose a file made by 'tsr bundle' or by 'Report a bug'."
                )
        limits = Limits(
            self._settings.worker_memory_mb, computing=_COMPUTING, wall=_WALL, writable=(folder,), nice=NICE
        )
        check = "app.bundles.checking:check_bundle"
        try:
            result: JsonObject = self._sandboxes.run(
                check, path, folder, self._settings.video_limits, limits=limits, stop=stop
            )
        except SandboxesClosed as error:
            raise Busy(f"The import was ended: {error}. Nothing was imported.") from None
        except SandboxError as error:
            raise _refused(f"{path.name} cannot be read: {error}.") from None
        except TsrError as error:
            # The folder of the unpacked bundle means nothing to a person and is removed soon.
            reported = str(error).replace(f"{folder / 'bundle'}{os.sep}", "").replace(str(folder), "")
            raise _refused(reported, error.kind if isinstance(error, ImportFormatError) else "broken") from None
        return result

    def _store(
        self,
        manifest: Manifest,
        place: Path,
        folder: Path,
        documents: Mapping[str, TrackDoc],
        spans: Mapping[int, tuple[int, int]],
        report: BundleReportView,
        author: str,
    ) -> BundleImport:
        home = self._settings.home
        run_id = uuid.uuid4().hex
        clip = place / manifest.clip.file
        digest = manifest.clip.sha256
        upload = self._uploads.path_of(digest, clip.suffix)
        with self._uploads.lock(digest), moving_files(home, run_id, upload) as moves, self._database.write() as session:
            video = self._video(session, manifest, clip, upload, moves)
            # an engine track without boxes in the clip can have boxes that people drew
            tracks = len({f"m{track}" for track in spans} | {key for key in documents if key.startswith("m")})
            run = self._run(manifest, video.id, run_id, report, tracks, read_header(folder / EVIDENCE).labels)
            session.add(run)
            session.flush()
            self._correct(session, run, documents, spans, report, author)
            moves.move(folder / EVIDENCE, home / "runs" / run_id)
            # The event tells pages whether the file exists, so move it into place before.
            publish_run(session, self._events, run)
            views = video_view(session, video), run_view(run)
        return BundleImport(video=views[0], run=views[1], report=report)

    def _video(self, session: Session, manifest: Manifest, clip: Path, upload: Path, moves: FileMoves) -> Video:
        """The clip as a video of the library. A known video whose file is missing gets the clip as its file."""
        video = session.scalars(
            select(Video).where(Video.id == manifest.clip.sha256).options(undefer(Video.frame_table))
        ).first()
        if video is None:
            video = Video(id=manifest.clip.sha256, name=_clip_name(manifest), path=str(upload), owned=True)
            video.size = clip.stat().st_size
            session.add(video)
            session.flush()
            self._jobs.submit(session, "import", video.id, priority=10)
            moves.move(clip, upload)
            return video
        require_local(session, video.place, video.name)
        if not Path(video.path).is_file():
            moves.move(clip, upload)
            video.path, video.owned = str(upload), True
        return video

    def _run(
        self,
        manifest: Manifest,
        video_id: str,
        run_id: str,
        report: BundleReportView,
        tracks: int,
        labels: tuple[str, ...] | None,
    ) -> Run:
        frames, offset = manifest.frames, manifest.clip.offset
        preset, changed = _configuration(manifest)
        now = datetime.now(UTC)
        count = frames.stop - frames.start
        return Run(
            id=run_id,
            video_id=video_id,
            name=f"{manifest.run.name or 'Run'} of a bundle"[:120],
            state="complete",
            preset=preset,
            parameters=changed,
            first=frames.start - offset,
            stop=frames.stop - offset,
            folder=f"runs/{run_id}",
            engine_version=manifest.run.engine_version[:32],
            models=dict(manifest.run.models),
            labels=labels_of_model(labels),
            frames_done=count,
            frames_total=count,
            tracks=tracks,
            summary={
                "bundle": report.model_dump(mode="json"),
                "seconds": 0.0,
                "focus": focus_of(params_of(preset, changed), named=True),
            },
            started=now,
            finished=now,
        )

    def _correct(
        self,
        session: Session,
        run: Run,
        documents: Mapping[str, TrackDoc],
        spans: Mapping[int, tuple[int, int]],
        report: BundleReportView,
        author: str,
    ) -> None:
        """Store the corrections as one operation of the log, so that one undo reverts them."""
        if not documents:
            return
        untouched = {f"m{track}": engine_doc(track, *span) for track, span in spans.items()}
        before = {key: untouched.get(key) for key in documents}
        command = {"name": "import_bundle", "video": report.video_name, "offset": report.offset}
        self._edits.record(session, run, author, command, before, documents, report.first)


def _first_problem(expectation: Expectation, expected: Sequence[ExpectedView], first: int) -> tuple[int, str | None]:
    """Original frame and sign of the first expectation that failed, or of the first one if none failed."""
    views = sorted(zip(expectation.expected, expected, strict=True), key=lambda pair: pair[1].met)
    if not views:
        return first, None
    shown = views[0][0]
    return (shown.frames or expectation.signs[shown.sign].frames[-1:])[0], shown.sign


def _configuration(manifest: Manifest) -> tuple[str, JsonObject]:
    """Preset, and the parameters that differ from it; parameters that this version does not know are left out."""
    preset = manifest.run.preset if manifest.run.preset in PRESETS else "default"
    params = Params.preset(preset)
    defaults = params.model_dump(mode="json")
    changed: JsonObject = {}
    stored = current_sections(manifest.run.parameters)
    for section, leaf in Params.names():
        values = stored.get(section)
        if not isinstance(values, dict) or leaf not in values or values[leaf] == defaults[section][leaf]:
            continue
        try:
            params.with_settings([(leaf, as_setting(values[leaf]))])
        except UsageError:
            continue
        changed[leaf] = values[leaf]
    return preset, changed


def _clip_name(manifest: Manifest) -> str:
    stem = manifest.video.name.rsplit(".", 1)[0].replace("/", "_")[:80] or "clip"
    frames = manifest.frames
    return f"{stem} {frames.first}-{frames.stop - 1}.{manifest.clip.file.rsplit('.', 1)[1]}"


def _refused(message: str, kind: ImportProblem = "broken") -> ApiError:
    return file_error(message, kind, "bad_bundle")
