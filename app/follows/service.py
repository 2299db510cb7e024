"""Starts follows, returns their proposals, and drops follows that no page reads."""

from __future__ import annotations

import asyncio
import time
import uuid
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime, timedelta

from sqlalchemy import delete, or_, select
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from app.edits.checks import known_frames
from app.errors import Invalid, NotFound
from app.follows.view import FollowAnchor, FollowView, Only, follow_view
from app.jobs.queue import JobQueue
from app.storage.database import Database
from app.storage.lookup import require_run
from app.storage.models import Follow, FollowPiece, Job
from app.storage.servers import is_local, require_local

LEASE_S = 20.0
"""Seconds without a request after which a follow in progress is dropped; a page that reloads comes back sooner."""
RESULT_LIFETIME_S = 86_400.0
"""Seconds without a request after which finished proposals are dropped. They cost nothing, and the page of a person who
has gone home, or who works in another tab, makes few requests or none."""
_PRIORITY = 30
"""Priority before what-ifs, recordings and exports, because a person waits for the proposals."""
_RENEW_INTERVAL_S = 4.0
"""Seconds between updates of the time of a page's last request."""
_POLL_S = 0.025
"""Seconds between queries of the database while a page waits for proposals."""
_FAST_POLL_S = 0.008
"""Shorter interval until the first proposal, because a person waits for it, seconds."""
_FAST_POLL_FOR_S = 1.0
"""Seconds for which the shorter interval is used."""


class FollowService:
    """Follows of all runs. Their proposals are removed when they are accepted, dropped or abandoned."""

    def __init__(self, database: Database, jobs: JobQueue) -> None:
        self._database = database
        self._jobs = jobs
        self._swept_at = self._woke_at = datetime.min.replace(tzinfo=UTC)

    def start(
        self,
        run_id: str,
        author: str,
        key: str,
        anchors: Sequence[FollowAnchor],
        only: Only | None = None,
        first: int = 0,
        last: int | None = None,
    ) -> FollowView:
        """Start to follow a sign; the author's earlier follow in this run is dropped.

        Args:
            run_id: the run of the track.
            author: the person.
            key: the track, for the page; it need not have a document.
            anchors: boxes that a person has set, one per frame.
            only: one direction, or only between the anchors.
            first: first frame for proposals.
            last: last frame for proposals; None: the last of the video.

        Raises:
            NotFound: no such run.
            Conflict: the frames of the video are not known yet.
            Invalid: the video does not have a frame, two anchors share a frame, or one lies outside of first to last.
        """
        with self._database.write(durable=False) as session:
            run = require_run(session, run_id)
            require_local(session, run.place, run.name)
            frames = known_frames(session, run)
            last = frames - 1 if last is None else min(last, frames - 1)
            sorted_anchors = sorted(anchors, key=lambda anchor: anchor.frame)
            _require_usable(sorted_anchors, only, first, last, frames)
            for earlier in session.scalars(select(Follow).where(Follow.run_id == run_id, Follow.author == author)):
                self._drop(session, earlier)
            follow = Follow(
                id=uuid.uuid4().hex,
                run_id=run_id,
                author=author,
                key=key,
                request={
                    "anchors": [anchor.model_dump(mode="json") for anchor in sorted_anchors],
                    "only": only,
                    "first": first,
                    "last": last,
                },
            )
            session.add(follow)
            session.flush()
            self._jobs.submit(session, "follow", follow.id, priority=_PRIORITY)
            view = follow_view(follow, (), 0)
        self._jobs.notify_standby(None)
        return view

    def expect(self, run_id: str, frame: int) -> None:
        """Let an idle worker prepare for a follow, because a person has selected a box.

        Raises:
            NotFound: no such run.
        """
        with self._database.read_once() as session:
            require_run(session, run_id)
        self._jobs.notify_standby(("follow", {"run_id": run_id, "frame": frame}))

    def view(self, follow_id: str, after: int = 0) -> FollowView:
        """Return the proposals from one piece on; the request keeps the follow alive.

        Raises:
            NotFound: it was dropped, accepted or abandoned.
        """
        with self._database.read() as session:
            follow = _require(session, follow_id)
            view = _view(session, follow, after)
            silent = abs(datetime.now(UTC) - follow.asked)  # a clock can be set back
        if silent > timedelta(seconds=_RENEW_INTERVAL_S):
            with self._database.write() as session:
                _require(session, follow_id).asked = datetime.now(UTC)
        return view

    async def wait(self, follow_id: str, after: int, seconds: float) -> FollowView:
        """Like :meth:`view`, but return as soon as there are new proposals or another note, or after some seconds.

        Raises:
            NotFound: as for :meth:`view`.
        """
        began, note = time.monotonic(), None
        while True:
            view = await asyncio.to_thread(self.view, follow_id, after)
            waited = time.monotonic() - began
            note = view.note if note is None else note
            is_news = view.next > after or view.note != note or view.state not in ("queued", "running")
            if is_news or waited >= seconds:
                return view
            await asyncio.sleep(_FAST_POLL_S if not after and waited < _FAST_POLL_FOR_S else _POLL_S)

    def newest(self, run_id: str, author: str) -> FollowView | None:
        """Return the follow of an author in a run; None: there is none."""
        with self._database.read() as session:
            follow = session.scalars(select(Follow).where(Follow.run_id == run_id, Follow.author == author)).first()
            return None if follow is None else _view(session, follow, 0)

    def drop(self, follow_id: str) -> None:
        """Stop a follow and delete its proposals, if it exists."""
        with self._database.write() as session:
            follow = session.get(Follow, follow_id)
            if follow is not None:
                self._drop(session, follow)

    def sweep(self) -> None:
        """Drop follows that no page has read lately; after a failure of the database the next call tries again.

        While the computer slept no page could read them, and a clock that was set only looks like that. After such a
        jump pages have the time of a lease to come back.
        """
        now = datetime.now(UTC)
        if abs(now - self._swept_at) > timedelta(seconds=LEASE_S):
            self._woke_at = now
        self._swept_at = now
        since = now - timedelta(seconds=LEASE_S)
        if self._woke_at > since:
            return
        with suppress(SQLAlchemyError):
            with self._database.read() as session:
                abandoned = _abandoned(session)
            if abandoned:
                with self._database.write() as session:
                    for follow in _abandoned(session):
                        self._drop(session, follow)

    def _drop(self, session: Session, follow: Follow) -> None:
        self._jobs.cancel(session, follow.id)
        # a running follow is deleted when its worker has stopped
        session.execute(delete(Job).where(Job.subject == follow.id, Job.state.not_in(("queued", "running"))))
        session.execute(delete(FollowPiece).where(FollowPiece.follow_id == follow.id))
        session.delete(follow)
        session.flush()


def _require(session: Session, follow_id: str) -> Follow:
    follow = session.get(Follow, follow_id)
    if follow is None:
        raise NotFound(
            "These proposals no longer exist: they were accepted, dropped, or not read by any page. Follow again."
        )
    return follow


def _view(session: Session, follow: Follow, after: int) -> FollowView:
    query = select(FollowPiece).where(FollowPiece.follow_id == follow.id, FollowPiece.number >= after)
    pieces = session.scalars(query.order_by(FollowPiece.number)).all()
    return follow_view(follow, [piece.proposals for piece in pieces], pieces[-1].number + 1 if pieces else after)


def _abandoned(session: Session) -> Sequence[Follow]:
    now = datetime.now(UTC)
    idle_since, expired = now - timedelta(seconds=LEASE_S), now - timedelta(seconds=RESULT_LIFETIME_S)
    is_active = Follow.state.in_(("queued", "running"))
    # servers read their own follows only, because their clocks can differ by more than a lease
    is_idle = is_active & (Follow.asked < idle_since) & is_local(session, Job.place)
    query = select(Follow).outerjoin(Job, Job.subject == Follow.id).where(or_(Follow.asked < expired, is_idle))
    return session.scalars(query).all()


def _require_usable(anchors: Sequence[FollowAnchor], only: Only | None, first: int, last: int, frames: int) -> None:
    if anchors[-1].frame >= frames:
        raise Invalid(
            f"The video has frames 0 to {frames - 1}. Got {anchors[-1].frame}.", field="anchors", code="no_such_frame"
        )
    numbers = [anchor.frame for anchor in anchors]
    if len(set(numbers)) < len(numbers):
        raise Invalid("Two anchors lie in one frame. Keep one of them.", field="anchors")
    if numbers[0] < first or numbers[-1] > last:
        raise Invalid(f"The anchors must lie in frames {first} to {last}, the ones to follow in.", field="anchors")
    if only == "between" and len(anchors) < 2:
        raise Invalid(
            "Following between anchors needs two of them. Correct the box in a second frame.", field="anchors"
        )
