"""Finds the frame at which the engine must start to reach a later frame in the state of the run.

After a frame without a live track, the engine's state depends on earlier frames only through the number of its last
track. So the engine starts at the last such frame before the range. This frame is included, because the camera shift
of the next one is measured against its picture.
"""

from __future__ import annotations

from dataclasses import dataclass

from tsr_engine.errors import EvidenceError, UsageError
from tsr_engine.evidence import EvidenceReader

__all__ = ["MAX_LEAD_FRAMES", "LeadIn", "find_lead_in"]

MAX_LEAD_FRAMES = 900
"""Largest number of lead-in frames."""


@dataclass(frozen=True, slots=True)
class LeadIn:
    """The frames before a range.

    Attributes:
        start: first frame of the engine.
        first_id: number of the first track that is born from there on.
        whole: whether the run's state is rebuilt exactly; False: tracks that were alive at ``start`` are missing and
            must be found again.
    """

    start: int
    first_id: int
    whole: bool


def find_lead_in(reader: EvidenceReader, first: int, *, most: int = MAX_LEAD_FRAMES) -> LeadIn:
    """Find the lead-in to the frames from ``first`` on.

    Args:
        reader: the run.
        first: first frame of the range.
        most: largest number of frames before it.

    Raises:
        EvidenceError: the run has stored no frame.
        UsageError: the run has not stored the frame.
    """
    begin, last = reader.first_frame, reader.last_frame
    if begin is None or last is None:
        raise EvidenceError(f"{reader.folder} holds no frames. Track the video first.")
    if not begin <= first <= last:
        raise UsageError(f"The run has the frames {begin} to {last}. Got {first}; choose frames among them.")
    quiet = reader.last_empty_frame(before=first)
    start = begin if quiet is None else quiet
    whole = first - start <= most
    if not whole:
        start = first - most
    # Numbers count births, so the smallest later number is the next one. In the frame without tracks none is born.
    before, after = 0, []
    for track in reader.tracks():
        if track.first_frame < start or track.first_frame == quiet:
            before = max(before, track.track_id)
        else:
            after.append(track.track_id)
    return LeadIn(start, min(after, default=before + 1), whole)
