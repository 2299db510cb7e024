"""Counts the tracks to which people have given a label."""

from __future__ import annotations

from sqlalchemy import distinct, func, select

from app.body_model import Model
from app.labels.references import videos_using
from app.labels.store import newest
from app.storage.database import Database
from app.storage.models import Run, TrackDocument, Video


class LabelUse(Model):
    """Use of a label."""

    tracks: int
    """Number of tracks of all runs to which a person has given the label, without deleted ones."""
    videos: int
    """Their videos."""


def label_usage(database: Database, key: str) -> dict[int, LabelUse]:
    """Count the tracks to which people have given each label of a set, by label id; labels without tracks are left out.

    The model's classes do not count unless a person has confirmed them. Ids are the stored ones: a merged label keeps
    its tracks.

    Raises:
        NotFound: no such set.
    """
    label = TrackDocument.document["class_id"].as_integer().label("label")
    gone = TrackDocument.document["gone"].as_boolean()
    with database.read() as session:
        newest(session, key)
        given = (
            select(label, TrackDocument.run_id, TrackDocument.key, Run.video_id)
            .join(Run, Run.id == TrackDocument.run_id)
            .join(Video, Video.id == Run.video_id)
            .where(videos_using(session, key), gone.is_(False))
            .subquery()
        )
        rows = session.execute(
            select(given.c.label, func.count(), func.count(distinct(given.c.video_id)))
            .where(given.c.label >= 0)
            .group_by(given.c.label)
        )
        return {number: LabelUse(tracks=tracks, videos=videos) for number, tracks, videos in rows}
