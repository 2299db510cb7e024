"""Finds the verdicts of the gate that another tau would change, in the whole run.

What counts is what the lanes show: confirmed tracks up to their last frame. In the frame after it, in which a track is
given up, its prediction was judged as well, but nothing is shown there.
"""

from __future__ import annotations

from app.evidence.tables import tau_of
from app.shapes import Model
from tsr_engine.evidence.reader import EvidenceReader

__all__ = ["FlippedTrack", "Flips", "flips"]

_SHOWN = (
    "FROM gates g JOIN tracks t ON t.track_id = g.track_id "
    "WHERE t.confirmed_frame IS NOT NULL AND g.frame <= t.last_frame"
)


class FlippedTrack(Model):
    """One track with verdicts that turn over."""

    id: int
    flips: int
    frame: int
    """The first frame of them."""


class Flips(Model):
    """Answer for one tau. The verdicts stand on the run's own boxes: what a replay would make of them is not told."""

    tau: float
    run_tau: float
    verdicts: int
    """All that count."""
    to_confident: int
    to_rejected: int
    tracks: list[FlippedTrack]
    """In order of id."""


def flips(reader: EvidenceReader, tau: float) -> Flips:
    """Count them; a candidate that could not be judged stays rejected."""
    turned = (
        f"SELECT g.track_id, count(*), sum(g.confident), min(g.frame) {_SHOWN} "
        "AND coalesce(g.l_positive < ?, 0) <> g.confident GROUP BY g.track_id ORDER BY g.track_id"
    )
    rows = reader.query(turned, (tau,))
    rejected = sum(row[2] for row in rows)
    return Flips(
        tau=tau,
        run_tau=tau_of(reader),
        verdicts=reader.query(f"SELECT count(*) {_SHOWN}")[0][0],
        to_confident=sum(row[1] for row in rows) - rejected,
        to_rejected=rejected,
        tracks=[FlippedTrack(id=row[0], flips=row[1], frame=row[3]) for row in rows],
    )
