"""Shared helpers for tests of the tool's bundles."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from app.bundles.service import BundleService
from app.edits.documents import KeyFrame, Note, Segment, TrackDoc
from app.job_kinds import KINDS
from app.jobs.context import TaskContext
from app.jobs.worker import perform
from app.outputs.service import OutputService
from app.storage.models import Output, TrackDocument
from tests import toy_pipeline
from tests.app.toy_server import Server

FIRST, STOP = 46, 70
"""The frames of the bundle; the second toy sign is in view in all of them."""
LABEL, WRONG = 14, 3


def sign_box(frame: int) -> tuple[float, float, float, float]:
    """The second sign as drawn."""
    x1, y1, x2, y2 = toy_pipeline.sign_box(frame % 40).tolist()
    return x1, y1, x2, y2


def store_documents(home: Any, *documents: TrackDoc) -> None:
    """Store documents as a person's edits."""
    with home.database.write() as session:
        for row in session.query(TrackDocument).filter(TrackDocument.run_id == home.run_id):
            session.delete(row)
        session.flush()
        for doc in documents:
            content = doc.model_dump(mode="json")
            session.add(TrackDocument(run_id=home.run_id, key=doc.key, revision=max(1, doc.revision), document=content))


def corrections() -> tuple[TrackDoc, ...]:
    """Another label and two boxes for track 2, a missed sign elsewhere, and a note."""
    note = Note(id="n1", frame=50, text="look at this", author="eve", time="2026-01-01T00:00:00+00:00")
    keys = {
        "40": KeyFrame(box=(1.0, 2.0, 11.0, 12.0), interpolate=True),
        "56": KeyFrame(box=(17.0, 2.0, 27.0, 12.0), interpolate=True),
        "62": KeyFrame(box=(23.0, 2.0, 33.0, 12.0), outside=True),
    }
    drawn = TrackDoc(key="habcdef", revision=2, class_id=WRONG, keys=keys)
    relabelled = TrackDoc(
        key="m2",
        revision=3,
        class_id=WRONG,
        segments=(Segment(track=2, first=44, last=74),),
        keys={"50": KeyFrame(box=sign_box(50)), "60": KeyFrame(box=sign_box(60))},
        notes=(note,),
    )
    return relabelled, drawn


def run_next_job(home: Any) -> Output:
    """Run the next job in this process; returns its output."""
    with home.database.write() as session:
        job = home.jobs.claim(session, home.jobs.waiting_ids(session)[0])
    assert job is not None
    task = TaskContext(home.settings, home.database, home.events, home.jobs, job, lambda: False)
    perform(task, KINDS)
    return output_service(home).get(job.subject)


def output_service(home: Any) -> OutputService:
    """The service of a toy home."""
    return OutputService(home.settings, home.database, home.events, home.jobs)


def bundle_service(home: Any) -> BundleService:
    """The service of a toy home."""
    return BundleService(home.database, home.evidence, output_service(home))


class ToyBundle(NamedTuple):
    """A finished bundle and where it comes from."""

    home: Any
    path: Path
    summary: dict[str, Any]


@pytest.fixture(scope="module")
def bundled(home: Any) -> ToyBundle:
    store_documents(home, *corrections())
    bundle_service(home).start(home.run_id, FIRST, STOP, note="reads as a stop sign")
    made = run_next_job(home)
    assert made.state == "complete", made.error
    return ToyBundle(home, home.settings.home / made.path, made.summary)


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    server = Server(tmp_path / "other")
    with server.client:
        yield server
