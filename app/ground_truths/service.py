"""Operations on ground truth."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from sqlalchemy import delete, select
from sqlalchemy.orm import Session, undefer

from app.errors import Invalid, NotFound
from app.storage.database import Database
from app.storage.ground_truth_rows import Rows, pack, parse, unpack
from app.storage.lookup import require_video
from app.storage.models import GroundTruth
from tsr_engine.evaluation.track_tables import truth_table
from tsr_engine.track_table import TrackTable

MAX_FRAMES = 256
"""Maximum number of frames in a request."""


class GroundTruthService:
    """Imports, lists, reads and removes ground truths."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def put(self, video_id: str, name: str, content: bytes) -> GroundTruth:
        """Import a CSV, completely or not at all; it replaces a ground truth of the same name.

        Raises:
            NotFound: no such video.
            Invalid: a line breaks a rule; the message names the first one and the rule.
        """
        with self._database.read() as session:
            video = require_video(session, video_id)
            frames = video.frames if video.state == "ready" else None
        return self.put_rows(video_id, name, parse(content, frames))

    def put_rows(
        self, video_id: str, name: str, rows: Rows, begin: Callable[[Session], None] | None = None
    ) -> GroundTruth:
        """Store checked rows; they replace a ground truth of the same name.

        Args:
            video_id: the video.
            name: name of the ground truth.
            rows: columns of ``app.storage.ground_truth_rows.COLUMNS``.
            begin: called first in the same transaction.

        Raises:
            NotFound: no such video.
        """
        truth = GroundTruth(id=uuid.uuid4().hex, video_id=video_id, name=name, boxes=pack(rows), count=len(rows))
        with self._database.write() as session:
            require_video(session, video_id)
            if begin is not None:
                begin(session)
            session.execute(delete(GroundTruth).where(GroundTruth.video_id == video_id, GroundTruth.name == name))
            session.add(truth)
        return truth

    def of_video(self, video_id: str) -> Sequence[GroundTruth]:
        """Ground truths of a video by name.

        Raises:
            NotFound: no such video.
        """
        with self._database.read() as session:
            require_video(session, video_id)
            return session.scalars(
                select(GroundTruth).where(GroundTruth.video_id == video_id).order_by(GroundTruth.name)
            ).all()

    def rows(self, truth_id: str) -> tuple[str, str, Rows]:
        """Video, name and rows of one ground truth; columns as in ``app.storage.ground_truth_rows.COLUMNS``.

        Raises:
            NotFound: no such ground truth.
        """
        with self._database.read() as session:
            query = select(GroundTruth).where(GroundTruth.id == truth_id).options(undefer(GroundTruth.boxes))
            truth = session.scalars(query).first()
            if truth is None:
                raise NotFound(f"There is no ground truth {truth_id[:40]!r}.")
            return truth.video_id, truth.name, unpack(truth.boxes)

    def window(self, truth_id: str, first: int, last: int) -> Rows:
        """Rows of ``first <= frame <= last``.

        Raises:
            NotFound: no such ground truth.
            Invalid: the window is empty or too long.
        """
        if not first <= last < first + MAX_FRAMES:
            raise Invalid(f"Request 1 to {MAX_FRAMES} frames. Got {first} to {last}.", field="last")
        rows = self.rows(truth_id)[2]
        return rows[slice(*np.searchsorted(rows[:, 0], [first, last + 1]))]

    def boxes(self, truth_id: str) -> tuple[str, str, TrackTable]:
        """Video, name, and the rows as boxes; tracks are named ``t`` and their number."""
        video_id, name, rows = self.rows(truth_id)
        table = truth_table(rows)
        ids, track = np.unique(table.track, return_inverse=True)
        return video_id, name, replace(table, track=track, names=tuple(f"t{i}" for i in ids.tolist()))

    def remove(self, truth_id: str) -> None:
        """Remove one ground truth.

        Raises:
            NotFound: no such ground truth.
        """
        with self._database.write() as session:
            truth = session.get(GroundTruth, truth_id)
            if truth is None:
                raise NotFound(f"There is no ground truth {truth_id[:40]!r}.")
            session.delete(truth)
