"""Which verdicts of the gate another tau would turn over, in the whole run."""

from __future__ import annotations

from app.evidence.tables import tau_of
from app.shapes import Model
from tsr_engine.evidence.reader import EvidenceReader

__all__ = ["FlippedTrack", "Flips", "flips"]


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
    """All verdicts of the run."""
    to_confident: int
    to_rejected: int
    tracks: list[FlippedTrack]
    """In order of id."""


def flips(reader: EvidenceReader, tau: float) -> Flips:
    """Count them; a candidate that could not be judged stays rejected."""
    confirmed = {row[0] for row in reader.query("SELECT track_id FROM tracks WHERE confirmed_frame IS NOT NULL")}
    sql = (
        "SELECT track_id, count(*), sum(confident), min(frame) FROM gates "
        "WHERE coalesce(l_positive < ?, 0) <> confident GROUP BY track_id ORDER BY track_id"
    )
    rows = [row for row in reader.query(sql, (tau,)) if row[0] in confirmed]
    rejected = sum(row[2] for row in rows)
    return Flips(
        tau=tau,
        run_tau=tau_of(reader),
        verdicts=reader.query("SELECT count(*) FROM gates")[0][0],
        to_confident=sum(row[1] for row in rows) - rejected,
        to_rejected=rejected,
        tracks=[FlippedTrack(id=row[0], flips=row[1], frame=row[3]) for row in rows],
    )
