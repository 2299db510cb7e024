"""The job ``follow``: stores proposals in small pieces, so pages see the first ones at once."""

from __future__ import annotations

import time
from contextlib import AbstractContextManager
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from sqlalchemy.orm import Session, undefer

from app.follows.prepared_video import open_prepared
from app.jobs.context import Stopped, TaskContext
from app.storage.models import Follow, FollowPiece, Run, Video
from app.training.folders import models_of_run
from app.videos.checked_file import library_file
from app.videos.file_changes import require_unchanged
from app.videos.packed_table import unpack
from tsr_engine.follow import Anchor, FollowerModels, Proposal, follow
from tsr_engine.follow_video import load_follower
from tsr_engine.json_shapes import JsonObject
from tsr_engine.pipeline import one_blas_thread

_PIECE_INTERVAL_S = 0.08
"""Seconds between pieces of proposals."""


def follow_track(task: TaskContext) -> None:
    """Follow from the anchors; an interrupted follow starts over, because it takes only seconds.

    Raises:
        Stopped: the job was asked to stop, or the follow was dropped.
    """
    with task.database.read() as session:
        follow_row = _require_wanted(session.get(Follow, task.job.subject))
        run = session.get_one(Run, follow_row.run_id)
        video = session.get_one(Video, run.video_id, options=(undefer(Video.frame_table),))
        models = models_of_run(task.settings, session, run) if run.kind != "imported" else task.settings.models
    file = library_file(task.settings, video)
    require_unchanged(task.database, file, video)
    pieces = _Pieces(task)
    pieces.begin()
    request = follow_row.request
    table = None if video.frame_table is None else unpack(video.frame_table)
    with open_prepared(file, table, task.settings.video_limits) as pictures, one_blas_thread():
        events = follow(
            pictures,
            [Anchor(anchor["frame"], np.array(anchor["box"], dtype=np.float64)) for anchor in request["anchors"]],
            _follower_models(models),
            direction=request["only"] if request["only"] in ("forward", "backward") else None,
            first=request["first"],
            last=request["last"],
            between=request["only"] == "between",
            cancelled=task.should_stop,
        )
        for event in events:
            if isinstance(event, Proposal):
                pieces.add(event)
            elif event.reason == "cancelled":
                raise Stopped
            else:
                pieces.end({name: getattr(event, name) for name in ("direction", "frame", "reason", "sentence")})
    if task.should_stop():
        raise Stopped
    pieces.complete()


@lru_cache(maxsize=2)
def _follower_models(models: Path | None) -> FollowerModels:
    """The models that following needs, cached: a version's folder never changes."""
    return load_follower(models)


def warm() -> None:
    """Load what the next follow with the shipped models needs; following noise once loads the compiled parts."""
    noise = np.random.default_rng(0).integers(0, 256, (120, 160, 3)).astype(np.uint8)
    still = SimpleNamespace(picture=noise, corrupt=False)
    anchor = Anchor(1, np.array([40.0, 30.0, 80.0, 70.0]))
    for _ in follow(lambda k: still if 0 <= k < 4 else None, [anchor], _follower_models(None)):
        pass


def _require_wanted(follow: Follow | None) -> Follow:
    if follow is None:
        raise Stopped
    return follow


class _Pieces:
    """Stores proposals in pieces, the first one at once."""

    def __init__(self, task: TaskContext) -> None:
        self._task = task
        self._number = 0
        self._waiting: list[list[object]] = []  # see FollowPiece.proposals
        self._endings: list[JsonObject] = []
        self._reported = 0.0

    def begin(self) -> None:
        """Delete the proposals of an earlier attempt."""
        with self._task.write(durable=False) as session:
            follow = _require_wanted(session.get(Follow, self._task.job.subject))
            self._number = follow.pieces
            follow.state, follow.error, follow.note, follow.endings = "running", None, "", []

    def add(self, proposal: Proposal) -> None:
        """Add one proposal."""
        edges = [round(float(edge), 2) for edge in proposal.box]
        self._waiting.append([proposal.frame, *edges, round(float(proposal.confidence), 3), proposal.source])
        # the page knows the anchors, so the first other box is sent at once
        if proposal.source != "anchor" and time.monotonic() - self._reported > _PIECE_INTERVAL_S:
            self._store("running")

    def end(self, ending: JsonObject) -> None:
        """Record the end of one direction."""
        self._endings.append(ending)
        self._store("running")

    def complete(self) -> None:
        """Mark the follow as complete, and end the job."""
        self._store("complete", self._task.complete(durable=False))

    def _store(self, state: str, transaction: AbstractContextManager[Session] | None = None) -> None:
        self._reported = time.monotonic()
        with transaction or self._task.write(durable=False) as session:
            follow = _require_wanted(session.get(Follow, self._task.job.subject))
            if self._waiting:
                session.add(FollowPiece(follow_id=follow.id, number=self._number, proposals=self._waiting))
                self._number += 1
                self._waiting = []
            follow.state, follow.endings, follow.pieces = state, list(self._endings), self._number
