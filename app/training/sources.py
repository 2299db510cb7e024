"""Sources of a retraining: current reviews, and exports with the changes since they were made."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.body_model import Model
from app.edits.history import undone_operations
from app.storage.lookup import current_run_last
from app.storage.models import Edit, Output, Run, TrackDocument, Video


class ReviewSource(Model):
    """The current review of a video: that of its newest run with corrections."""

    run: str
    run_name: str
    video: str
    video_name: str
    edit_revision: int
    """Number of the newest edit; 0: there is none, its documents were imported."""
    accepted: int
    rejected: int
    """False positives, which training uses as background."""
    left: int
    """Undecided tracks."""


class ExportAge(Model):
    """Changes of the reviews in an export since it was made."""

    id: str
    edits: int
    """Number of edits made since."""
    undone: int
    """Number of its edits that were undone since."""
    gone: list[str]
    """Names of its videos whose run was removed."""


class TrainingSources(Model):
    """All sources."""

    reviews: list[ReviewSource]
    exports: list[ExportAge]


def training_sources(session: Session) -> TrainingSources:
    """List the sources: videos by name, exports from new to old."""
    query = select(Output).where(Output.kind == "export", Output.state == "complete").order_by(Output.created.desc())
    return TrainingSources(
        reviews=_reviews(session), exports=[export_age(session, output) for output in session.scalars(query)]
    )


def export_age(session: Session, output: Output) -> ExportAge:
    """Count the changes since an export was made."""
    edits = undone = 0
    gone: list[str] = []
    for video in output.summary.get("videos", ()):
        run = session.get(Run, str(video.get("run", {}).get("id", "")))
        if run is None:
            gone.append(str(video.get("name", "a video")))
            continue
        revision = int(video.get("edit_revision", 0))
        later = select(Edit.kind, Edit.reverts).where(Edit.run_id == run.id, Edit.seq > revision).order_by(Edit.seq)
        rows = [(kind, reverts) for kind, reverts in session.execute(later)]
        edits += len(rows)
        held = select(Edit.op_id).where(Edit.run_id == run.id, Edit.seq <= revision)
        undone += len(undone_operations(rows) & set(session.scalars(held)))
    return ExportAge(id=output.id, edits=edits, undone=undone, gone=gone)


def _reviews(session: Session) -> list[ReviewSource]:
    edits = select(Edit.run_id, func.max(Edit.seq)).group_by(Edit.run_id)
    newest: dict[str, int] = {run_id: seq for run_id, seq in session.execute(edits)}  # noqa: C416 - rows, not pairs
    runs = (
        select(Run).where(Run.kind != "whatif", Run.state.in_(["complete", "cancelled"])).order_by(*current_run_last())
    )
    counts = _counts(session)
    chosen = {run.video_id: run for run in session.scalars(runs) if run.id in counts}
    names = {video.id: video.name for video in session.execute(select(Video.id, Video.name))}
    found = []
    for run in chosen.values():
        run_counts = counts[run.id]
        tracks = (run.tracks or 0) + run_counts["made"] - run_counts["gone"]
        found.append(
            ReviewSource(
                run=run.id,
                run_name=run.name,
                video=run.video_id,
                video_name=names[run.video_id],
                edit_revision=newest.get(run.id, 0),
                accepted=run_counts["accepted"],
                rejected=run_counts["rejected"],
                left=max(0, tracks - run_counts["accepted"] - run_counts["rejected"]),
            )
        )
    return sorted(found, key=lambda one: (one.video_name, one.video))


def _counts(session: Session) -> Mapping[str, Mapping[str, int]]:
    """Number of documents of each run by verdict; ``made`` by people; ``gone``: deleted tracks of the engine."""
    gone = TrackDocument.document["gone"].as_boolean()
    review = TrackDocument.document["review"].as_string()
    is_engine_track = TrackDocument.key.startswith("m")
    query = select(TrackDocument.run_id, is_engine_track, gone, review, func.count()).group_by(
        TrackDocument.run_id, is_engine_track, gone, review
    )
    counts: dict[str, dict[str, int]] = defaultdict(lambda: defaultdict(int))
    for run_id, engines, absent, verdict, count in session.execute(query):
        if absent:
            counts[run_id]["gone"] += count if engines else 0
            continue
        counts[run_id][verdict] += count
        counts[run_id]["made"] += 0 if engines else count
    return counts
