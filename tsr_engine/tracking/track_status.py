"""Tracks after a frame, as the tracker reports them."""

from __future__ import annotations

from dataclasses import dataclass

from tsr_engine.records import Event, FloatArray, Prediction, Source, TrackState


@dataclass(frozen=True, slots=True)
class TrackStatus:
    """One track after a frame."""

    track_id: int
    state: TrackState
    source: Source
    box: FloatArray
    """Shape (4,): the frame's result."""
    score: float
    prediction: Prediction | None
    """None in the track's first frame."""
    detection: int | None
    """Row of the associated detection."""
    missed: int
    """Frames since the last detection or confident relocalisation; 0 if this frame has one."""


@dataclass(frozen=True, slots=True)
class TrackedFrame:
    """The living tracks by id and the events of a frame, returned by ``Tracker.finish``.

    ``tracks`` does not contain tracks that ended in this frame; their events give the reason. Events: ``born``,
    ``confirmed``, ``missed`` (first of several frames without evidence), ``died``.
    """

    tracks: tuple[TrackStatus, ...]
    events: tuple[Event, ...]
