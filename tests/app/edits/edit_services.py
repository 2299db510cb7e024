"""An edit service over toy tracks."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.edits.bulk import BulkEdits
from app.edits.documents import TrackDoc
from app.edits.log_store import LogStore, documents_of
from app.edits.service import EditService
from app.events import EventBus
from app.labels.store import start
from app.storage.database import Database
from app.storage.models import Base, Run, Video
from tsr_engine.labels.model import LabelSet

RUN, OTHER = "a" * 32, "b" * 32
VIDEO, FRAMES = "f" * 64, 75


@dataclass
class ToyEvidence:
    """The part of the evidence API that the edit service uses."""

    spans: dict[int, tuple[int, int]] = field(default_factory=lambda: {1: (0, 20), 2: (15, 40), 3: (50, 70)})
    labels: dict[int, int | None] = field(default_factory=lambda: {1: 14, 2: None, 3: 38})

    def span(self, _run_id: str, track: int) -> tuple[int, int] | None:
        return self.spans.get(track)

    def all_spans(self, _run_id: str) -> dict[int, tuple[int, int]]:
        return self.spans

    def gaps(self, _run_id: str, track: int) -> list[tuple[int, int | None]]:
        return [(self.spans[track][1] + 1, None)]

    def label(self, _run_id: str, track: int) -> int | None:
        return self.labels.get(track)


@dataclass
class EditServices:
    """A service with one complete run."""

    database: Database
    service: EditService
    bulk: BulkEdits
    evidence: ToyEvidence
    run: str = RUN

    def documents(self, run: str = RUN) -> dict[str, TrackDoc]:
        """The documents of a run."""
        with self.database.read() as session:
            return documents_of(session, run)


def make_edit_services(url: str, labels: LabelSet | None = None) -> EditServices:
    """A service on a fresh database.

    Args:
        url: of the database.
        labels: set of the video; None: the default of a new library.
    """
    database = Database(url)
    Base.metadata.create_all(database.engine)
    with database.write() as session:
        session.add(Video(id=VIDEO, name="v", path="/v", size=1, warnings=[], state="ready", frames=FRAMES))
        if labels is not None:
            start(session, labels, "ann", "Made.")
            session.get_one(Video, VIDEO).label_set = labels.key
        session.flush()
        session.add(Run(id=RUN, video_id=VIDEO, state="complete", parameters={}, models={}, summary={}))
    evidence = ToyEvidence()
    log = LogStore(database, EventBus(), evidence)  # type: ignore[arg-type]
    return EditServices(database, EditService(log), BulkEdits(log), evidence)
