"""Videos that have a track of a label, with an answer to an attribute, or in a state of review."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import ColumnElement, func, select, true

from app.search.filters import NO_LABEL_WORD, State, answered, labelled
from app.search.index import SearchIndex
from app.shapes import Model
from app.storage.database import Database
from app.storage.models import SearchRun, SearchTrack
from tsr_engine.labels.model import NO_LABEL

__all__ = ["LabelledVideos", "Matches", "Wanted"]

_BUDGET_S = 1.5
"""Longest time that one question spends on runs that the search has not read yet."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What one and the same track must have.

    Attributes:
        label: key, name or alias of a label; ``-1``: not in the set; None: any.
        attribute: name of an attribute; None: any.
        value: an answer to it, as text; None: any that a person has given.
        state: its state of review; None: any.
    """

    label: str | None = None
    attribute: str | None = None
    value: str | None = None
    state: State | None = None


class Matches(Model):
    """Videos with such tracks.

    Attributes:
        videos: id of the video -> how many of its tracks.
        left: videos that are not counted yet; ask again.
        unreadable: videos whose tracks cannot be read here.
    """

    videos: dict[str, int]
    left: int
    unreadable: int


class LabelledVideos:
    """Answers for the library; thread-safe."""

    def __init__(self, database: Database, index: SearchIndex) -> None:
        self._database = database
        self._index = index

    def find(self, wanted: Wanted, budget: float = _BUDGET_S) -> Matches:
        """Find videos, each by the run that stands for it, as people have left its tracks.

        Args:
            wanted: what a track must have.
            budget: longest time spent on runs that the search has not read yet, s.

        Raises:
            Invalid: no label set in use has such a label.
        """
        self._index.follow(budget)
        row = SearchTrack
        where: list[ColumnElement[bool]] = [row.current == true()]
        with self._database.read() as session:
            if wanted.label is not None:
                word = NO_LABEL_WORD if wanted.label == str(NO_LABEL) else wanted.label
                where.append(labelled(session, [word]))
            if wanted.attribute is not None:
                where.append(answered(session, wanted.attribute, wanted.value))
            if wanted.state is not None:
                where.append(row.state == wanted.state)
            counted = session.execute(select(row.video_id, func.count()).where(*where).group_by(row.video_id)).all()
            broken = select(func.count()).where(SearchRun.error.is_not(None), SearchRun.current == true())
            return Matches(
                videos={row[0]: row[1] for row in counted},
                left=self._index.unread_videos(),
                unreadable=session.scalar(broken) or 0,
            )
