"""Counts the tracks of each label."""

from __future__ import annotations

from collections.abc import Set

from sqlalchemy import distinct, func, select, true
from sqlalchemy.orm import Session

from app.body_model import Model
from app.labels.store import newest
from app.storage.models import SearchRun, SearchTrack


class LabelUse(Model):
    """Use of a label."""

    tracks: int
    """Number of tracks with the label, in the current run of each video, without regions to ignore."""
    videos: int
    """Their videos."""


class LabelUsage(Model):
    """Use of the labels of a set."""

    labels: dict[int, LabelUse]
    """By id of the label. Labels without tracks are left out."""
    unread: int
    """Number of videos whose tracks or newest edits are not counted, because the search has not read them."""


def label_usage(session: Session, key: str, unread: Set[str]) -> LabelUsage:
    """Count the tracks with each label of a set, as corrected by people.

    Ids are the stored ones: a merged label keeps its tracks.

    Args:
        session: reads.
        key: key of the set.
        unread: current runs of videos that the search still has to read.

    Raises:
        NotFound: no such set.
    """
    newest(session, key)
    row = SearchTrack
    query = select(row.label, func.count(), func.count(distinct(row.video_id)))
    query = query.where(row.set_key == key, row.label >= 0, row.current == true(), row.state != "ignored")
    found = session.execute(query.group_by(row.label))
    labels = {label: LabelUse(tracks=tracks, videos=videos) for label, tracks, videos in found}
    broken = select(SearchRun.run_id).where(SearchRun.error.is_not(None), SearchRun.current == true())
    return LabelUsage(labels=labels, unread=len({*unread, *session.scalars(broken)}))  # a broken one may be read again
