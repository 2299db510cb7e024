"""Answers searches, page by page."""

from __future__ import annotations

import base64
import binascii
import json
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Literal

from pydantic import Field
from sqlalchemy import ColumnElement, and_, func, or_, select, tuple_
from sqlalchemy.orm import Session

from app.body_model import PLAIN, Model
from app.errors import Invalid
from app.labels.store import newest
from app.search.filters import MeantLabel, SearchFilters, conditions, labels_for_words
from app.storage.lookup import in_parts
from app.storage.models import Run, SearchRun, SearchTrack, Video, VideoTag
from tsr_engine.labels.model import NO_LABEL

MAX_COUNTED = 10_000
"""Maximum number of tracks to count; an answer only says that there are more."""
_MAX_UNREADABLE = 5
_MAX_ALTERNATIVES = 250
"""Maximum number of alternatives in one condition: SQLite limits its depth."""


class SearchRequest(SearchFilters):
    """A page of a search."""

    sort: Literal["uncertainty", "size", "edited"] = "uncertainty"
    order: Literal["desc", "asc"] = "desc"
    limit: int = Field(60, ge=1, le=500)
    cursor: str = Field("", max_length=400, pattern=PLAIN, description="`next` of the page before")


class FoundLabel(Model):
    """The label of a track."""

    set: str
    id: int
    name: str


class FoundTrack(Model):
    """One track, with the frame and the box to show."""

    run: str
    run_name: str
    video: str
    video_name: str
    tags: list[str]
    key: str
    label: FoundLabel | None
    """None: none of the set's labels, or not classified."""
    state: str
    uncertainty: float
    size: float
    frame: int
    box: tuple[float, float, float, float]
    first: int
    last: int
    revision: int
    author: str | None
    edited: str | None
    notes: bool


class Unreadable(Model):
    """A run whose tracks the search cannot read."""

    run: str
    run_name: str
    video_name: str
    message: str


class SearchAnswer(Model):
    """One page of results."""

    tracks: list[FoundTrack]
    next: str | None
    """Cursor of the next page; None: there is none."""
    total: int
    """Number of found tracks; at most 10,000 are counted."""
    more: bool
    """Whether there are more than that."""
    labels: list[MeantLabel]
    """Labels that the words of ``label`` mean."""
    unread: int
    """Number of runs whose tracks or newest edits are missing in the answer."""
    unreadable: list[Unreadable]
    """The first unreadable runs, with the reason."""
    unreadable_count: int


def answer(session: Session, request: SearchRequest, unread: int) -> SearchAnswer:
    """Answer a search.

    Raises:
        Invalid: a value of the request is wrong, or the cursor belongs to another search.
    """
    where = conditions(session, request)
    counted = select(SearchTrack.run_id).where(*where).limit(MAX_COUNTED + 1).subquery()
    total = session.scalar(select(func.count()).select_from(counted)) or 0
    sort: ColumnElement[float] = getattr(SearchTrack, request.sort)
    if total <= MAX_COUNTED:  # sorting few rows is faster than walking the index of their order: avoid that index
        sort = sort + 0
    sort_columns = sort, SearchTrack.run_id, SearchTrack.key
    page = [*where]
    if request.cursor:
        after = _cursor_position(request)
        page.append(tuple_(*sort_columns) < after if request.order == "desc" else tuple_(*sort_columns) > after)
    ordered = [each.desc() if request.order == "desc" else each.asc() for each in sort_columns]
    rows = list(session.scalars(select(SearchTrack).where(*page).order_by(*ordered).limit(request.limit + 1)))
    has_more = len(rows) > request.limit
    rows = rows[: request.limit]
    unreadable, broken_count = _unreadable(session)
    return SearchAnswer(
        tracks=_found(session, rows),
        next=_cursor(request, rows[-1]) if has_more else None,
        total=min(total, MAX_COUNTED),
        more=total > MAX_COUNTED,
        labels=labels_for_words(session, request.label),
        unread=unread,
        unreadable=unreadable,
        unreadable_count=broken_count,
    )


def found_tracks(session: Session, keys: Sequence[tuple[str, str]]) -> list[FoundTrack]:
    """Tracks by run and key, if the tables have them."""
    rows: list[SearchTrack] = []
    for part in in_parts(keys, _MAX_ALTERNATIVES):
        wanted = [and_(SearchTrack.run_id == run, SearchTrack.key == key) for run, key in part]
        rows += session.scalars(select(SearchTrack).where(or_(*wanted)))
    return _found(session, rows)


def _found(session: Session, rows: Sequence[SearchTrack]) -> list[FoundTrack]:
    runs = _names(session, Run, {row.run_id for row in rows})
    videos = _names(session, Video, {row.video_id for row in rows})
    tags: dict[str, list[str]] = {}
    for part in in_parts(list(videos)):
        query = select(VideoTag.video_id, VideoTag.tag).where(VideoTag.video_id.in_(part)).order_by(VideoTag.tag)
        for video_id, tag in session.execute(query):
            tags.setdefault(video_id, []).append(tag)
    sets = {key: newest(session, key) for key in {row.set_key for row in rows}}
    found = []
    for row in rows:
        labels = sets[row.set_key]
        label = None if row.label == NO_LABEL else labels.get(labels.resolved(row.label))
        found.append(
            FoundTrack.from_row(
                row,
                run=row.run_id,
                run_name=runs.get(row.run_id, ""),
                video=row.video_id,
                video_name=videos.get(row.video_id, ""),
                tags=tags.get(row.video_id, []),
                label=None if label is None else FoundLabel(set=labels.key, id=label.id, name=label.name),
                size=round(row.size, 1),
                box=(round(row.x1, 2), round(row.y1, 2), round(row.x2, 2), round(row.y2, 2)),
                edited=None if row.edited == 0 else datetime.fromtimestamp(row.edited, UTC).isoformat(),
                notes=row.notes != "",
            )
        )
    return found


def _names(session: Session, table: type[Run] | type[Video], ids: set[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for part in in_parts(sorted(ids)):
        found |= {row[0]: row[1] for row in session.execute(select(table.id, table.name).where(table.id.in_(part)))}
    return found


def _unreadable(session: Session) -> tuple[list[Unreadable], int]:
    unreadable = SearchRun.error.is_not(None)
    query = select(SearchRun.run_id, Run.name, Video.name, SearchRun.error).where(unreadable)
    query = query.join(Run, Run.id == SearchRun.run_id).join(Video, Video.id == Run.video_id).order_by(Run.order.desc())
    first = [
        Unreadable(run=run, run_name=name, video_name=video, message=error or "")
        for run, name, video, error in session.execute(query.limit(_MAX_UNREADABLE))
    ]
    count = session.scalar(select(func.count()).select_from(SearchRun).where(unreadable)) if first else 0
    return first, count or 0


def _cursor(request: SearchRequest, row: SearchTrack) -> str:
    position = [request.sort, request.order, getattr(row, request.sort), row.run_id, row.key]
    return base64.urlsafe_b64encode(json.dumps(position).encode()).decode()


def _cursor_position(request: SearchRequest) -> tuple[float, str, str]:
    try:
        sort, order, value, run_id, key = json.loads(base64.urlsafe_b64decode(request.cursor.encode()))
        position = float(value), str(run_id), str(key)
        f"{run_id}{key}".encode()  # a lone surrogate is no text
    except (binascii.Error, ValueError, TypeError):
        position = None
    if position is None or (sort, order) != (request.sort, request.order) or position[0] != position[0]:
        raise Invalid("The cursor belongs to another search. Start at the first page.", field="cursor")
    return position
