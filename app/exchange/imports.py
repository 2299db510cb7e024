"""Imports files of other tools atomically: as ground truth, as a run, or as corrections of a run."""

from __future__ import annotations

import shutil
import uuid
from collections.abc import Callable, Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from sqlalchemy.orm import Session

from app.body_model import Model
from app.edits.bulk import BulkEdits
from app.errors import Busy, Invalid
from app.events import EventBus
from app.exchange.added_labels import FittedTracks, LabelSetChanged, fit_tracks, remember_names, remembered_names
from app.exchange.annotate_run import annotate_run
from app.exchange.as_ground_truth import ground_truth_rows
from app.exchange.as_run import write_run
from app.exchange.import_file import ImportFile, VideoTarget, read_import_file
from app.exchange.marks import is_ignored, marks
from app.exchange.run_sources import require_exportable, run_source, video_info
from app.ground_truths.service import GroundTruthService
from app.labels.store import labels_of_video
from app.outputs.file_moves import moving_files
from app.runs.view import publish_run
from app.settings import Settings
from app.storage.database import Database
from app.storage.lookup import require_video
from app.storage.models import Run
from app.storage.servers import require_local
from app.videos.packed_table import unpack
from tsr_engine.evidence.schema import LOCK_FILE
from tsr_engine.exchange.dataset import REJECTED, Dataset, Skipped, Track
from tsr_engine.exchange.formats import ImportLimits
from tsr_engine.exchange.track_numbers import track_numbers
from tsr_engine.io.locks import is_locked
from tsr_engine.plural import plural

ImportKind = Literal["annotation", "truth", "run"]
DRAWN_BY_HAND = "drawn by hand"
"""Origin of a run without an engine and without a file."""
_PART = ".import-"
_MAX_ATTEMPTS = 50
"""Attempts to store while others change the label set."""
Begin = Callable[[Session], None]
"""Called first in the transaction that stores tracks."""


class SkippedView(Model):
    """Something that was not imported."""

    what: str
    reason: str


class ImportResult(Model):
    """The result of an import.

    Attributes:
        kind: import as this kind.
        id: the ground truth or run; for an annotation the corrected run.
        tracks: number of imported tracks; for an annotation, of new and changed ones.
        boxes: number of their boxes.
        same: number of tracks of an annotation that the run already showed.
        edit: number of the operation in the run's log: the annotation, or an imported run's marks (hidden, verdicts,
            notes); one undo reverts it. None: there is nothing to undo.
        repaired: repairs, one sentence each.
        skipped: what was left out.
    """

    kind: ImportKind
    id: str
    tracks: int
    boxes: int
    same: int = 0
    edit: int | None = None
    repaired: list[str]
    skipped: list[SkippedView]


class ImportService:
    """Reads a file, checks all of it, then stores it in one transaction."""

    def __init__(
        self,
        settings: Settings,
        database: Database,
        events: EventBus,
        edits: BulkEdits,
        ground_truths: GroundTruthService,
    ) -> None:
        self._settings = settings
        self._database = database
        self._events = events
        self._edits = edits
        self._ground_truths = ground_truths

    def import_file(self, video_id: str, file: ImportFile, kind: ImportKind, run_id: str | None = None) -> ImportResult:
        """Import a file.

        Args:
            video_id: the video.
            file: the file.
            kind: import as this kind.
            run_id: the run that an annotation corrects.

        Raises:
            NotFound: no such video or run.
            Conflict: the video is not imported, or the run is not complete.
            Invalid: an annotation without a run of this video.
            UsageError: an unknown format, option or class.
            ImportFormatError: the file breaks a rule; the message names file, line and rule.
        """
        target = self.check(video_id, kind, run_id)
        return self.store(video_id, target, file, kind, run_id, read_import_file(file, target))

    def check(self, video_id: str, kind: ImportKind, run_id: str | None) -> VideoTarget:
        """Check the target of an import before its file is read. Arguments and errors as for ``import_file``."""
        with self._database.read() as session:
            video = require_video(session, video_id, table=True)
            require_local(session, video.place, video.name)
            facts = video_info(video, self._settings)
            assert video.frame_table is not None
            if kind == "annotation":
                require_exportable(session, self._settings, _require_run_id(run_id), video_id)
            limits = ImportLimits(self._settings.import_max_tracks, self._settings.import_max_boxes)
            labels = labels_of_video(session, video_id)
            return VideoTarget(
                facts, unpack(video.frame_table), video.size, limits, labels, remembered_names(session, labels)
            )

    def store(
        self,
        video_id: str,
        target: VideoTarget,
        file: ImportFile,
        kind: ImportKind,
        run_id: str | None,
        dataset: Dataset,
    ) -> ImportResult:
        """Store the result of ``read_import_file``. Arguments and errors as for ``import_file``.

        Raises:
            Busy: other people keep changing the label set.
        """
        tracks = list(dataset.videos[0].tracks())
        author = file.author or self._settings.author
        for _ in range(_MAX_ATTEMPTS):
            with self._database.read() as session:
                newest = labels_of_video(session, video_id)
            if newest.key != target.labels.key:
                newest = target.labels  # the video uses another set now, which the transaction refuses
            fitted = fit_tracks(newest, target.labels, dataset.labels, tracks, file.path.name)

            def begin(session: Session, fitted: FittedTracks = fitted) -> None:
                fitted.store(session, self._events, video_id, author)
                remember_names(session, target.labels, file.label_map, author)

            try:
                if kind == "annotation":
                    return self._annotation(video_id, _require_run_id(run_id), file, dataset, fitted.tracks, begin)
                if kind == "truth":
                    return self._truth(video_id, file, dataset, fitted.tracks, begin)
                return self._run(video_id, target, file, dataset, fitted.tracks, begin)
            except LabelSetChanged:
                continue
        raise Busy(f"Too many people are changing the label set '{target.labels.name}'. Import the file again.")

    def create_empty_run(
        self, video_id: str, name: str, author: str, target: VideoTarget | None = None
    ) -> ImportResult:
        """Make a run without tracks, for a person who draws all of them.

        Args:
            video_id: the video.
            name: name of the run.
            author: author of the run.
            target: result of ``check``, if already known.

        Raises:
            NotFound: no such video.
            Conflict: the video is not imported.
        """
        target = self.check(video_id, "run", None) if target is None else target
        nothing = Dataset(target.labels, (target.video.without_tracks(),))
        file = ImportFile(Path(DRAWN_BY_HAND), name, DRAWN_BY_HAND, author=author)
        return self._run(video_id, target, file, nothing, [], lambda _: None)

    def sweep(self) -> None:
        """Remove files of imports whose process died; running imports are not touched."""
        for place in ("runs", "uploads"):
            for folder in (self._settings.home / place).glob(f"{_PART}*"):
                if not is_locked(folder / LOCK_FILE):
                    shutil.rmtree(folder, ignore_errors=True)

    def new_part(self) -> Path:
        """Make a new folder for a file that is being received; ``sweep`` removes it if it is left over."""
        folder = self._settings.home / "uploads" / f"{_PART}{uuid.uuid4().hex}"
        folder.mkdir(parents=True)
        return folder

    # ------------------------------------------------------------------------------------------------------ inside

    def _truth(
        self, video_id: str, file: ImportFile, dataset: Dataset, tracks: list[Track], begin: Begin
    ) -> ImportResult:
        signs = [track for track in tracks if track.state != REJECTED]
        if not signs:
            raise Invalid(f"{file.path.name} contains only rejected tracks, which are no signs.", code="nothing")
        rows = ground_truth_rows(signs)
        truth = self._ground_truths.put_rows(video_id, file.name, rows, begin)
        counts = (
            (len(tracks) - len(signs), "rejected track", "Ground truth holds only signs."),
            (sum(len(track.notes) for track in signs), "note", "Ground truth has no notes."),
        )
        left_out = [Skipped(plural(count, what), reason) for count, what, reason in counts if count]
        return _result("truth", truth.id, len(signs), len(rows), dataset, left_out)

    def _run(
        self, video_id: str, target: VideoTarget, file: ImportFile, dataset: Dataset, tracks: list[Track], begin: Begin
    ) -> ImportResult:
        run_id = uuid.uuid4().hex
        home = self._settings.home
        # the scratch folder is removed with the import
        part = home / "runs" / f"{_PART}{run_id}" if file.scratch is None else file.scratch / "run"
        folder = home / "runs" / run_id
        origin = {"file": file.path.name, "format": file.format or "found out"}
        try:
            write_run(part, target.video, target.size, target.table, tracks, origin)
            now = datetime.now(UTC)
            run = Run(
                id=run_id,
                video_id=video_id,
                kind="imported",
                name=file.name,
                state="complete",
                preset="default",
                parameters={},
                first=0,
                stop=None,
                folder=f"runs/{run_id}",
                engine_version="imported",
                models={},
                frames_done=target.video.frames,
                frames_total=target.video.frames,
                tracks=len(tracks),
                summary={"imported": origin},
                labels={"set": target.labels.key},
                started=now,
                finished=now,
            )
            author = file.author or self._settings.author
            marked = marks(tracks, track_numbers((track.uid for track in tracks), min_number=0), author)
            edit = None
            with moving_files(home, run_id) as moves, self._database.write() as session:
                require_video(session, video_id)
                begin(session)
                session.add(run)
                publish_run(session, self._events, run)
                if marked:
                    before = {key: untouched for key, (untouched, _) in marked.items()}
                    after = {key: doc for key, (_, doc) in marked.items()}
                    edit = self._edits.record(session, run, author, _command(file), before, after).seq
                moves.move(part, folder)
        except BaseException:
            shutil.rmtree(part, ignore_errors=True)
            raise
        boxes = sum(len(track.frames) for track in tracks)
        view = _result("run", run_id, len(tracks), boxes, dataset, _lost_in_run(tracks))
        return view.model_copy(update={"edit": edit})

    def _annotation(
        self, video_id: str, run_id: str, file: ImportFile, dataset: Dataset, tracks: list[Track], begin: Begin
    ) -> ImportResult:
        with self._database.read() as session:
            require_exportable(session, self._settings, run_id, video_id)
            source = run_source(session, self._settings, run_id)
        author = file.author or self._settings.author
        exported = dataset.videos[0].provenance.get("run", {}).get("id") == run_id
        result, seq = annotate_run(
            self._edits, source, run_id, tracks, author, _command(file), exported=exported, begin=begin
        )
        view = _result("annotation", run_id, result.changed + result.made, result.boxes, dataset, result.skipped)
        return view.model_copy(
            update={"same": result.same, "edit": seq, "repaired": [*view.repaired, *result.repaired]}
        )


def _require_run_id(run_id: str | None) -> str:
    if run_id is None:
        raise Invalid("An annotation corrects a run. Name it with run=.", field="run")
    return run_id


def _result(
    kind: ImportKind, identity: str, tracks: int, boxes: int, dataset: Dataset, left_out: Iterable[Skipped]
) -> ImportResult:
    skipped = [SkippedView(what=each.what, reason=each.reason) for each in (*dataset.skipped, *left_out)]
    return ImportResult(
        kind=kind, id=identity, tracks=tracks, boxes=boxes, repaired=list(dataset.repaired), skipped=skipped
    )


def _command(file: ImportFile) -> dict[str, str]:
    return {"name": "import", "file": file.path.name, "format": file.format or "found out"}


def _lost_in_run(tracks: Iterable[Track]) -> list[Skipped]:
    count = sum(0 if track.ignore is None or is_ignored(track) else int(track.ignore.sum()) for track in tracks)
    reason = "A run cannot hold single boxes to ignore, so they became ordinary boxes. Import the file as ground truth."
    return [Skipped(f"{count} marks 'ignore'", reason)] if count else []
