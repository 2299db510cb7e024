"""Turns stored frames back into inputs of the core, for replay and for resuming."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tsr_engine.detection.prior import with_prior
from tsr_engine.errors import EvidenceError
from tsr_engine.evidence import EvidenceReader, StoredPixels, differences
from tsr_engine.params import Params
from tsr_engine.pipeline.core import TrackingCore
from tsr_engine.pipeline.frame_input import FrameInput
from tsr_engine.pipeline.track_context import Models
from tsr_engine.records import Detections, FrameEvidence

RECOMPUTED = frozenset({"timings", "regions", "text"})
"""Fields of ``FrameEvidence`` and its parts in which a correct replay may differ from the run.

``text`` is the sentence of an event, whose wording may change between versions. The event's kind and values are
compared.
"""


def stored_input(frame: FrameEvidence, detections: Detections | None = None) -> tuple[FrameInput, StoredPixels]:
    """The core's input for a stored frame, and its pixels, which count missing ones.

    Args:
        frame: stored frame with regions.
        detections: detections to use, such as rescored ones; unset: the stored ones.
    """
    pixels = StoredPixels(frame.width, frame.height, frame.regions)
    used = frame.detections if detections is None else detections
    return FrameInput(frame.ordinal, frame.seconds, used, frame.shift, pixels), pixels


def rescore(detections: Detections, weight: float) -> Detections:
    """Detections with the final score ``raw + (P - 1/2) * weight`` (Eq. 2), best first.

    Suppression is not repeated, because the evidence lacks the boxes that the run suppressed.
    """
    scores = with_prior(detections.raw_scores, detections.prior, weight)
    order = np.argsort(-scores, kind="stable")
    return Detections(detections.boxes[order], detections.raw_scores[order], detections.prior[order], scores[order])


def start_core(reader: EvidenceReader, params: Params, parts: Models, *, first_id: int = 1) -> TrackingCore:
    """Make a core for the video of a run's evidence.

    Window rescoring is off if the run used another detector than ACF.

    Raises:
        EvidenceError: the store is empty or lacks what the core needs.
    """
    table = reader.header.frame_table
    try:
        size = int(table["width"]), int(table["height"])
        interval = float(table["interval"])
    except (KeyError, TypeError, ValueError):
        raise EvidenceError(f"{reader.folder} lacks the size and rate of its video. Track the video again.") from None
    if "detector" not in reader.header.models:
        parts = replace(parts, window_scorer=None)
    return TrackingCore(params, parts, *size, interval=interval, first_id=first_id)


def rebuild_core(reader: EvidenceReader, params: Params, parts: Models, last: int) -> TrackingCore:
    """The core as it was after frame ``last``; the frames since the last one without tracks are processed again.

    The parameters and trained parts are the run's own.

    Raises:
        EvidenceError: the evidence has no pixels, or a frame comes out differently than stored.
    """
    trackless = reader.last_empty_frame(before=last + 1)
    track_ids = [] if trackless is None else [track.track_id for track in reader.tracks(stop=trackless + 1)]
    core = start_core(reader, params, parts, first_id=1 + max(track_ids, default=0))
    if trackless is not None:
        core.skip(next(reader.frames(trackless, trackless + 1, pixels=False)).seconds)
    start = 0 if trackless is None else trackless + 1
    if start <= last and not reader.header.keep_pixels:
        raise EvidenceError(f"{reader.folder} holds no pixels, so its run cannot go on. Start over in a new folder.")
    for stored in reader.frames(start, last + 1):
        recomputed = core.step(stored_input(stored)[0])
        found = next(differences(recomputed, stored, ignore=RECOMPUTED), None)
        if found is not None:
            raise EvidenceError(
                f"{reader.folder} cannot be continued: frame {stored.ordinal} comes out differently here ({found}). "
                "Start over in a new folder."
            )
    return core
