"""Finds runs that the index must read, and the current run of each video."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from itertools import groupby
from typing import Final

from sqlalchemy import and_, or_, select
from sqlalchemy.orm import Session, load_only

from app.labels.mapping import run_classes
from app.labels.store import default_key, newest
from app.storage.lookup import current_run_last
from app.storage.models import Event, Run, SearchRun, Video
from app.storage.servers import is_local

FORMAT: Final = 3
"""Version of the rows' contents; raise it so that all rows are made again."""


@dataclass(frozen=True, slots=True)
class ExpectedRun:
    """A complete run of this server, in the state that the tables should have.

    Attributes:
        run_id: its id.
        video_id: its video.
        set_key: label set of the video.
        basis: changes with everything besides edits that its rows depend on.
        current: whether it is its video's current run.
    """

    run_id: str
    video_id: str
    set_key: str
    basis: str
    current: bool


def runs_have_changed(session: Session, after: int) -> bool:
    """Whether runs or label sets may have changed since the event with this number."""
    oldest = session.scalar(select(Event.seq).order_by(Event.seq).limit(1)) or 0
    if after < oldest:
        return True
    ended = and_(Event.kind == "run", Event.data["state"].as_string() != "running")
    query = select(Event.seq).where(Event.seq > after, or_(Event.kind.in_(("removed", "labels")), ended)).limit(1)
    return session.scalar(query) is not None


def expected_runs(session: Session) -> dict[str, ExpectedRun]:
    """All complete runs whose evidence lies here, by id."""
    default = default_key(session)
    query = (
        select(Run, Video.label_set)
        .join(Video, Video.id == Run.video_id)
        .where(Run.state == "complete", is_local(session, Run.place))
        .order_by(Run.video_id, *current_run_last())
        .options(load_only(Run.video_id, Run.kind, Run.order, Run.labels))
    )
    meanings: dict[tuple[str, str], str] = {}
    expected: dict[str, ExpectedRun] = {}
    for video_id, rows in groupby(session.execute(query).all(), key=lambda row: row[0].video_id):
        runs = [(run, label_set or default) for run, label_set in rows]
        candidates = [run for run, _ in runs if run.kind != "whatif"]
        for run, set_key in runs:
            meaning_key = json.dumps(run.labels, sort_keys=True), set_key
            if meaning_key not in meanings:
                classes = run_classes(run, newest(session, set_key))
                meanings[meaning_key] = repr([(number, classes.to_label(number)) for number in classes.numbers()])
            basis = hashlib.blake2b(repr((FORMAT, set_key, meanings[meaning_key])).encode(), digest_size=16)
            current = bool(candidates) and run is candidates[-1]
            expected[run.id] = ExpectedRun(run.id, video_id, set_key, basis.hexdigest(), current)
    return expected


def stale_runs(session: Session, wanted: dict[str, ExpectedRun], *, retry: bool) -> tuple[list[str], dict[str, bool]]:
    """Find runs that the tables lack.

    Args:
        session: reads.
        wanted: the wanted states of the runs.
        retry: also read runs that could not be read before.

    Returns:
        Runs to read, current runs of their videos first; and runs whose mark as current is wrong in the tables.
    """
    known = {row.run_id: row for row in session.scalars(select(SearchRun))}
    missing = [
        run
        for run in wanted.values()
        if (row := known.get(run.run_id)) is None or row.basis != run.basis or (retry and row.error is not None)
    ]
    flags = {
        run.run_id: run.current
        for run in wanted.values()
        if run.run_id in known and known[run.run_id].current != run.current
    }
    return [run.run_id for run in sorted(missing, key=lambda run: not run.current)], flags
