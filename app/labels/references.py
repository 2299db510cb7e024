"""Finds the label ids that stored data uses."""

from __future__ import annotations

import re

from sqlalchemy import ColumnElement, Text, cast, or_, select
from sqlalchemy.orm import Session

from app.labels.store import default_key
from app.storage.ground_truth_rows import COLUMNS, unpack
from app.storage.models import Edit, GroundTruth, Run, TrackDocument, Video

_CLASS = re.compile(r'"class_id": ?([0-9]+)')
_TRUTH_CLASS = COLUMNS.index("class_id")


def videos_using(session: Session, key: str) -> ColumnElement[bool]:
    """Condition on ``videos``: the video uses this set."""
    chosen = Video.label_set == key
    return or_(chosen, Video.label_set.is_(None)) if key == default_key(session) else chosen


def referenced_ids(session: Session, videos: ColumnElement[bool]) -> set[int]:
    """Return the ids in documents of tracks, in the log of edits (undo brings them back) and in ground truths.

    Args:
        session: reads.
        videos: condition on ``videos``.
    """
    found: set[int] = set()
    for column, table in ((TrackDocument.document, TrackDocument), (Edit.before, Edit), (Edit.after, Edit)):
        rows = select(cast(column, Text)).join(Run, Run.id == table.run_id).join(Video, Video.id == Run.video_id)
        for text in session.scalars(rows.where(videos).execution_options(yield_per=500)):
            found.update(map(int, _CLASS.findall(text or "")))
    boxes = select(GroundTruth.boxes).join(Video, Video.id == GroundTruth.video_id).where(videos)
    for packed in session.scalars(boxes.execution_options(yield_per=10)):
        found.update(int(number) for number in set(unpack(packed)[:, _TRUTH_CLASS].tolist()) if number >= 0)
    return found


def is_imported(session: Session, key: str) -> bool:
    """Whether the evidence of any run has ids of this set, because it was imported."""
    rows = session.scalars(select(Run.labels).where(Run.labels.is_not(None)))
    return any(labels is not None and labels.get("set") == key for labels in rows)
