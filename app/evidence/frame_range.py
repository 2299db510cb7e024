"""Checks ranges of frames in requests."""

from __future__ import annotations

from app.errors import Conflict, Invalid
from app.evidence.service import EvidenceService


def check_frames(
    evidence: EvidenceService, run_id: str, first: int, stop: int, output_kind: str, max_frames: int
) -> None:
    """Refuse a range of frames that the run has not stored.

    Raises:
        NotFound: no such run.
        Conflict: the run has no results yet.
        Invalid: the range is empty, too long, or not within the frames of the run.
    """
    if not first < stop <= first + max_frames:
        raise Invalid(f"A {output_kind} has 1 to {max_frames} frames. Got {first} to {stop}.", field="stop")
    stored = evidence.stored_frames(run_id)
    if stored is None:
        raise Conflict("The run has no results yet. Wait for its first frames.", code="no_evidence")
    if first < stored[0] or stop > stored[1] + 1:
        raise Invalid(
            f"The run has the frames {stored[0]} to {stored[1]}. Got {first} to {stop - 1}.",
            field="first" if first < stored[0] else "stop",
        )
