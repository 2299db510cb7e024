"""Copies signs of a ground truth to the corrections of a run, as one operation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from sqlalchemy import select

from app.body_model import Model
from app.edits.bulk import BulkEdits
from app.errors import Conflict, Invalid
from app.exchange.annotate_run import annotate_run
from app.exchange.run_sources import run_source
from app.ground_truths.service import GroundTruthService
from app.settings import Settings
from app.storage.database import Database
from app.storage.ground_truth_rows import Rows
from app.storage.models import Edit
from tsr_engine.exchange.dataset import Track
from tsr_engine.geometry.boxes import clip
from tsr_engine.labels.matching import LabelFinder, unknown_label
from tsr_engine.labels.model import LabelSet


class TakenOver(Model):
    """Result of copying the signs.

    Attributes:
        changed: number of tracks of the run that changed.
        made: number of new tracks.
        same: number of signs that the run already showed.
        op_id: id of the operation, for an undo; None: nothing has changed.
        repaired: repairs, one sentence each.
        skipped: what was left out and why, one sentence each.
    """

    changed: int
    made: int
    same: int
    op_id: str | None
    repaired: list[str]
    skipped: list[str]


class TakeOverService:
    """Copies signs of a ground truth to runs."""

    def __init__(
        self, settings: Settings, database: Database, edits: BulkEdits, ground_truths: GroundTruthService
    ) -> None:
        self._settings = settings
        self._database = database
        self._edits = edits
        self._ground_truths = ground_truths

    def take(
        self, run_id: str, truth_id: str, author: str, signs: Sequence[int] = (), label: int | str | None = None
    ) -> TakenOver:
        """Make a run show some signs of a ground truth; boxes to ignore are left out.

        Args:
            run_id: the run to correct.
            truth_id: a ground truth of its video.
            author: author of the correction.
            signs: their numbers in the ground truth.
            label: also all signs with this label, given by its id, key or name; -1: those without a label.

        Raises:
            NotFound: no such run or ground truth.
            Invalid: the ground truth belongs to another video or has no such sign, or the set has no such label.
            Conflict: the run is not complete, or all boxes of the signs are to be ignored.
        """
        video_id, name, rows = self._ground_truths.rows(truth_id)
        with self._database.read() as session:
            source = run_source(session, self._settings, run_id)
        label_id = _id_of(label, source.classes.labels) if isinstance(label, str) else label
        if source.video.sha256 != video_id:
            raise Invalid("The ground truth belongs to another video than the run.", field="truth")
        rows = rows[(rows[:, 0] >= source.first) & (rows[:, 0] < source.stop)]
        requested = set(signs)
        missing = sorted(requested - set(rows[:, 1].astype(int).tolist()))
        if missing:
            raise Invalid(
                f"{name} has no sign {missing[0]} in frames {source.first} to {source.stop - 1}, which the run has "
                "looked at. Choose another one.",
                field="signs",
            )
        rows[:, 2:6] = clip(rows[:, 2:6], source.video.width, source.video.height)
        sign_numbers = dict.fromkeys(
            [*signs, *(() if label_id is None else np.unique(rows[:, 1]).astype(int).tolist())]
        )
        tracks_by_sign = {sign: track for sign in sign_numbers if (track := _track(rows, sign)) is not None}
        tracks = [track for sign, track in tracks_by_sign.items() if sign in requested or track.label == label_id]
        if not tracks:
            raise Conflict(
                "There is nothing to take over: all boxes of these signs are marked to be ignored or lie outside the "
                "picture.",
                code="nothing",
            )
        command = {"name": "take_over", "truth": name, "signs": len(tracks)}
        result, seq = annotate_run(self._edits, source, run_id, tracks, author, command)
        with self._database.read() as session:
            op_id = None if seq is None else session.scalars(select(Edit.op_id).where(Edit.seq == seq)).one()
        return TakenOver(
            changed=result.changed,
            made=result.made,
            same=result.same,
            op_id=op_id,
            repaired=result.repaired,
            skipped=[f"{item.what}: {item.reason}" for item in result.skipped],
        )


def _id_of(word: str, labels: LabelSet) -> int:
    """Id of a label by its key or name.

    Raises:
        Invalid: the set has no such label.
    """
    match = LabelFinder(labels).find(word)
    if match is None:
        raise Invalid(unknown_label(word, labels), field="label")
    return match.label.id


def _track(rows: Rows, sign: int) -> Track | None:
    """One sign without its boxes to ignore and those outside the picture; None: no other box is left."""
    _, numbers, x1, y1, x2, y2, _, _, ignored = rows.T
    sign_rows = rows[(numbers == sign) & (ignored == 0) & (x2 > x1) & (y2 > y1)]
    if not len(sign_rows):
        return None
    labels = sign_rows[:, 6].astype(np.int64)
    values, counts = np.unique(labels, return_counts=True)
    label = int(values[counts.argmax()])
    return Track(
        uid=f"truth{sign}",
        label=label,
        frames=sign_rows[:, 0].astype(np.int64),
        boxes=np.ascontiguousarray(sign_rows[:, 2:6]),
        key=np.ones(len(sign_rows), np.bool_),
        occluded=sign_rows[:, 7] == 0,
        score=np.full(len(sign_rows), np.nan),
        labels=labels if len(values) > 1 else None,
        source="truth",
    )
