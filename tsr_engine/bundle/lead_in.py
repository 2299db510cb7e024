"""Finds the frame at which the engine must start to reach a later frame in the state of the run.

After a frame without a live track, the engine's state depends on earlier frames only through the number of its last
track. So the engine starts at the last such frame before the range. This frame is included, because the camera shift
of the next one is measured against its picture.
"""

from __future__ import annotations

from dataclasses import dataclass

from tsr_engine.errors import EvidenceError, UsageError
from tsr_engine.evidence import EvidenceReader

MAX_LEAD_FRAMES = 900
"""Largest number of lead-in frames."""


@dataclass(frozen=True, slots=True)
class LeadIn:
    """The frames before a range.

    Attributes:
        start: first frame of the engine.
        first_id: number of the first track that is born from there on.
        is_exact: whether the run's state is rebuilt exactly; False: tracks that were alive at ``start`` are missing and
            must be found again.
    """

    start: int
    first_id: int
    is_exact: bool


def find_lead_in(reader: EvidenceReader, first: int, *, max_frames: int = MAX_LEAD_FRAMES) -> LeadIn:
    """Find the lead-in to the frames from ``first`` on, of at most ``max_frames``.

    Raises:
        EvidenceError: the run has stored no frame.
        UsageError: the run has not stored the frame.
    """
    begin, last = reader.first_frame, reader.last_frame
    if begin is None or last is None:
        raise EvidenceError(f"{reader.folder} holds no frames. Track the video first.")
    if not begin <= first <= last:
        raise UsageError(f"The run has the frames {begin} to {last}. Got {first}; choose frames among them.")
    empty_frame = reader.last_empty_frame(before=first)
    start = begin if empty_frame is None else empty_frame
    is_exact = first - start <= max_frames
    if not is_exact:
        start = first - max_frames
    # Numbers count births, so the smallest later number is the next one. In the frame without tracks none is born.
    last_earlier_id, later_ids = 0, []
    for track in reader.tracks():
        if track.first_frame < start or track.first_frame == empty_frame:
            last_earlier_id = max(last_earlier_id, track.track_id)
        else:
            later_ids.append(track.track_id)
    return LeadIn(start, min(later_ids, default=last_earlier_id + 1), is_exact)
