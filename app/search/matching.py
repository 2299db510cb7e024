"""Finds videos that have a track with a label, a value of an attribute, or a state of review."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import ColumnElement, func, select, true

from app.body_model import Model
from app.search.filters import NO_LABEL_WORD, State, has_attribute, has_label
from app.search.index import SearchIndex
from app.storage.database import Database
from app.storage.models import SearchRun, SearchTrack
from tsr_engine.labels.model import NO_LABEL

_BUDGET_S = 1.5
"""Maximum time that one query spends on runs that are not in the tables yet, s."""


@dataclass(frozen=True, slots=True)
class TrackQuery:
    """Properties that a single track must have.

    Attributes:
        label: key, name or alias of a label; ``-1``: not in the set; None: any.
        attribute: name of an attribute; None: any.
        value: its value, as text; None: any that a person has set.
        state: its state of review; None: any.
    """

    label: str | None = None
    attribute: str | None = None
    value: str | None = None
    state: State | None = None


class Matches(Model):
    """Videos with such tracks.

    Attributes:
        videos: video id -> number of such tracks.
        left: number of videos that are not counted yet; ask again.
        unreadable: number of videos whose tracks cannot be read here.
    """

    videos: dict[str, int]
    left: int
    unreadable: int


class LabelledVideos:
    """Answers such queries for the library; thread-safe."""

    def __init__(self, database: Database, index: SearchIndex) -> None:
        self._database = database
        self._index = index

    def find(self, query: TrackQuery, budget: float = _BUDGET_S) -> Matches:
        """Find videos by the tracks of their current runs, with corrections.

        Args:
            query: properties of a track.
            budget: maximum time for runs that are not in the tables yet, s.

        Raises:
            Invalid: no label set in use has such a label.
        """
        self._index.update(budget)
        row = SearchTrack
        where: list[ColumnElement[bool]] = [row.current == true()]
        with self._database.read() as session:
            if query.label is not None:
                word = NO_LABEL_WORD if query.label == str(NO_LABEL) else query.label
                where.append(has_label(session, [word], exact_only=True))
            if query.attribute is not None:
                where.append(has_attribute(session, query.attribute, query.value))
            if query.state is not None:
                where.append(row.state == query.state)
            counted = session.execute(select(row.video_id, func.count()).where(*where).group_by(row.video_id)).all()
            unreadable = select(func.count()).where(SearchRun.error.is_not(None), SearchRun.current == true())
            return Matches(
                videos={row[0]: row[1] for row in counted},
                left=len(self._index.unread_current_runs()),
                unreadable=session.scalar(unreadable) or 0,
            )
