"""Finds the verdicts of the gate that another tau would change, in the whole run.

Only frames on the lanes count: those of confirmed tracks up to their last frame. The prediction of the next frame, in
which the track ends, was judged too, but is not shown.
"""

from __future__ import annotations

import numpy as np

from app.body_model import Model
from app.evidence.run_columns import tau_of
from tsr_engine.evidence.columns import read_columns
from tsr_engine.evidence.reader import EvidenceReader


class FlippedTrack(Model):
    """One track with verdicts that change."""

    id: int
    flips: int
    frame: int
    """First frame with a changed verdict."""


class Flips(Model):
    """Answer for one tau. Verdicts are those on the run's own boxes; a replay may give other boxes."""

    tau: float
    run_tau: float
    verdicts: int
    """Number of all verdicts."""
    to_confident: int
    to_rejected: int
    tracks: list[FlippedTrack]
    """In order of id."""


def flips(reader: EvidenceReader, tau: float) -> Flips:
    """Find verdicts that change at ``tau``; a candidate that could not be judged stays rejected."""
    names = ("track_id", "frame", "l_positive", "confident", "tracks.last_frame")
    rows = read_columns(reader, "gates", *names, confirmed=True)
    shown = rows.ints("frame") <= rows.ints("tracks.last_frame")
    confident = rows.ints("confident") > 0
    flipped = shown & ((rows.floats("l_positive") < tau) != confident)
    tracks, first_index, counts = np.unique(rows.ints("track_id")[flipped], return_index=True, return_counts=True)
    # ordered by frame, so the first entry of a track is its earliest frame
    frames = rows.ints("frame")[flipped][first_index]
    found = zip(tracks.tolist(), counts.tolist(), frames.tolist(), strict=True)
    return Flips(
        tau=tau,
        run_tau=tau_of(reader),
        verdicts=int(shown.sum()),
        to_confident=int((flipped & ~confident).sum()),
        to_rejected=int((flipped & confident).sum()),
        tracks=[FlippedTrack(id=track, flips=flips, frame=frame) for track, flips, frame in found],
    )
