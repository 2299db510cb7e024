"""Imports files of other tools atomically: as ground truth, as a run, or as corrections of a run."""

from __future__ import annotations

import shutil
import uuid
from collections.abc import Callable, Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from sqlalchemy.orm import Session

from app.edits.bulk import BulkEdits
from app.errors import Busy, Invalid
from app.events import EventBus
from app.exchange.added_labels import Fitted, Overtaken, fitted, keep_words, words_of
from app.exchange.annotate_run import annotate_run
from app.exchange.as_run import write_run
from app.exchange.as_truth import truth_rows
from app.exchange.dataset import Source
from app.exchange.incoming import Incoming, Onto, read_incoming
from app.exchange.marks import ignored, marks
from app.exchange.stored import home_source, require_source, video_facts
from app.ground_truths.service import GroundTruthService
from app.labels.store import labels_of_video
from app.outputs.placing import placing
from app.runs.view import publish_run
from app.settings import Settings
from app.shapes import Model
from app.storage.database import Database
from app.storage.models import Run
from app.storage.of_video import require_video
from app.storage.places import require_here
from app.videos.table import unpack
from tsr_engine.evidence.schema import LOCK_FILE
from tsr_engine.exchange.dataset import REJECTED, Dataset, Skipped, Track
from tsr_engine.exchange.formats import ImportLimits
from tsr_engine.exchange.track_numbers import track_numbers
from tsr_engine.io.locks import is_locked

__all__ = [
    "ImportKind",
    "ImportResult",
    "ImportService",
    "SkippedView",
]

ImportKind = Literal["annotation", "truth", "run"]
BY_HAND = "drawn by hand"
"""Origin of a run without an engine and without a file."""
_PART = ".import-"
_TRIES = 50
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

    def bring_in(self, video_id: str, incoming: Incoming, kind: ImportKind, run_id: str | None = None) -> ImportResult:
        """Import a file.

        Args:
            video_id: the video.
            incoming: the file.
            kind: import as this kind.
            run_id: the run that an annotation corrects.

        Raises:
            NotFound: no such video or run.
            Conflict: the video is not imported, or the run is not complete.
            Invalid: an annotation without a run of this video.
            UsageError: an unknown format, option or class.
            ImportFormatError: the file breaks a rule; the message names file, line and rule.
        """
        onto = self.check(video_id, kind, run_id)
        return self.store(video_id, onto, incoming, kind, run_id, read_incoming(incoming, onto))

    def check(self, video_id: str, kind: ImportKind, run_id: str | None) -> Onto:
        """Check the target of an import before its file is read. Arguments and errors as for ``bring_in``."""
        with self._database.read() as session:
            video = require_video(session, video_id, table=True)
            require_here(session, video.place, video.name)
            facts = video_facts(video, self._settings)
            assert video.frame_table is not None
            if kind == "annotation":
                require_source(session, self._settings, _named(run_id), video_id)
            limits = ImportLimits(self._settings.import_max_tracks, self._settings.import_max_boxes)
            labels = labels_of_video(session, video_id)
            return Onto(facts, unpack(video.frame_table), video.size, limits, labels, words_of(session, labels))

    def store(
        self, video_id: str, onto: Onto, incoming: Incoming, kind: ImportKind, run_id: str | None, dataset: Dataset
    ) -> ImportResult:
        """Store the result of ``read_incoming``. Arguments and errors as for ``bring_in``.

        Raises:
            Busy: other people keep changing the label set.
        """
        tracks = list(dataset.videos[0].tracks())
        author = incoming.author or self._settings.author
        for _ in range(_TRIES):
            with self._database.read() as session:
                newest = labels_of_video(session, video_id)
            if newest.key != onto.labels.key:
                newest = onto.labels  # the video uses another set now, which the transaction refuses
            fit = fitted(newest, onto.labels, dataset.labels, tracks, incoming.path.name)

            def begin(session: Session, fit: Fitted = fit) -> None:
                fit.store(session, self._events, video_id, author)
                keep_words(session, onto.labels, incoming.label_map, author)

            try:
                if kind == "annotation":
                    source = self._source(video_id, run_id)
                    return self._annotation(source, str(run_id), incoming, dataset, fit.tracks, begin)
                if kind == "truth":
                    return self._truth(video_id, incoming, dataset, fit.tracks, begin)
                return self._run(video_id, onto, incoming, dataset, fit.tracks, begin)
            except Overtaken:
                continue
        raise Busy(f"Too many people are changing the label set '{onto.labels.name}'. Import the file again.")

    def begin_by_hand(self, video_id: str, name: str, author: str, onto: Onto | None = None) -> ImportResult:
        """Make a run without tracks, for a person who draws all of them.

        Args:
            video_id: the video.
            name: name of the run.
            author: author of the run.
            onto: result of ``check``, if already known.

        Raises:
            NotFound: no such video.
            Conflict: the video is not imported.
        """
        onto = self.check(video_id, "run", None) if onto is None else onto
        nothing = Dataset(onto.labels, (onto.facts.without_tracks(),))
        return self._run(video_id, onto, Incoming(Path(BY_HAND), name, BY_HAND, author=author), nothing, [], _nothing)

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

    def _source(self, video_id: str, run_id: str | None) -> Source:
        with self._database.read() as session:
            require_source(session, self._settings, _named(run_id), video_id)
            return home_source(session, self._settings, _named(run_id))

    def _truth(
        self, video_id: str, incoming: Incoming, dataset: Dataset, tracks: list[Track], begin: Begin
    ) -> ImportResult:
        signs = [track for track in tracks if track.state != REJECTED]
        if not signs:
            raise Invalid(f"{incoming.path.name} contains only rejected tracks, which are no signs.", code="nothing")
        rows = truth_rows(signs)
        truth = self._ground_truths.put_rows(video_id, incoming.name, rows, begin)
        counts = (
            (len(tracks) - len(signs), "rejected track", "Ground truth holds only signs."),
            (sum(len(track.notes) for track in signs), "note", "Ground truth has no notes."),
        )
        lost = [Skipped(f"{count} {what}{'s' * (count != 1)}", reason) for count, what, reason in counts if count]
        return _result("truth", truth.id, len(signs), len(rows), dataset, lost)

    def _run(
        self, video_id: str, onto: Onto, incoming: Incoming, dataset: Dataset, tracks: list[Track], begin: Begin
    ) -> ImportResult:
        run_id = uuid.uuid4().hex
        home = self._settings.home
        # the scratch folder is removed with the import
        part = home / "runs" / f"{_PART}{run_id}" if incoming.scratch is None else incoming.scratch / "run"
        folder = home / "runs" / run_id
        about = {"file": incoming.path.name, "format": incoming.format or "found out"}
        try:
            write_run(part, onto.facts, onto.size, onto.table, tracks, about)
            now = datetime.now(UTC)
            run = Run(
                id=run_id,
                video_id=video_id,
                kind="imported",
                name=incoming.name,
                state="complete",
                preset="default",
                parameters={},
                first=0,
                stop=None,
                folder=f"runs/{run_id}",
                engine_version="imported",
                models={},
                frames_done=onto.facts.frames,
                frames_total=onto.facts.frames,
                tracks=len(tracks),
                summary={"imported": about},
                labels={"set": onto.labels.key},
                started=now,
                finished=now,
            )
            author = incoming.author or self._settings.author
            said = marks(tracks, track_numbers((track.uid for track in tracks), min_number=0), author)
            edit = None
            with placing(home, run_id) as work, self._database.write() as session:
                require_video(session, video_id)
                begin(session)
                session.add(run)
                publish_run(session, self._events, run)
                if said:
                    before = {key: bare for key, (bare, _) in said.items()}
                    after = {key: doc for key, (_, doc) in said.items()}
                    edit = self._edits.record(session, run, author, _command(incoming), before, after).seq
                work.put(part, folder)
        except BaseException:
            shutil.rmtree(part, ignore_errors=True)
            raise
        boxes = sum(len(track.frames) for track in tracks)
        reported = _result("run", run_id, len(tracks), boxes, dataset, _lost_in_run(tracks))
        return reported.model_copy(update={"edit": edit})

    def _annotation(
        self, source: Source, run_id: str, incoming: Incoming, dataset: Dataset, tracks: list[Track], begin: Begin
    ) -> ImportResult:
        author = incoming.author or self._settings.author
        exported = dataset.videos[0].provenance.get("run", {}).get("id") == run_id
        found, seq = annotate_run(
            self._edits, source, run_id, tracks, author, _command(incoming), exported=exported, begin=begin
        )
        reported = _result("annotation", run_id, found.changed + found.made, found.boxes, dataset, found.skipped)
        return reported.model_copy(
            update={"same": found.same, "edit": seq, "repaired": [*reported.repaired, *found.repaired]}
        )


def _nothing(_: Session) -> None:
    """Do nothing first in a transaction."""


def _named(run_id: str | None) -> str:
    if run_id is None:
        raise Invalid("An annotation corrects a run. Name it with run=.", field="run")
    return run_id


def _result(
    kind: ImportKind, identity: str, tracks: int, boxes: int, dataset: Dataset, lost: Iterable[Skipped]
) -> ImportResult:
    skipped = [SkippedView(what=each.what, reason=each.reason) for each in (*dataset.skipped, *lost)]
    return ImportResult(
        kind=kind, id=identity, tracks=tracks, boxes=boxes, repaired=list(dataset.repaired), skipped=skipped
    )


def _command(incoming: Incoming) -> dict[str, str]:
    return {"name": "import", "file": incoming.path.name, "format": incoming.format or "found out"}


def _lost_in_run(tracks: Iterable[Track]) -> list[Skipped]:
    count = sum(0 if track.ignore is None or ignored(track) else int(track.ignore.sum()) for track in tracks)
    reason = "A run cannot hold single boxes to ignore, so they became ordinary boxes. Import the file as ground truth."
    return [Skipped(f"{count} marks 'ignore'", reason)] if count else []
