"""Tracks after a frame, as the tracker reports them."""

from __future__ import annotations

from dataclasses import dataclass

from tsr_engine.records import Event, FloatArray, Prediction, Source, TrackState

__all__ = ["TrackStatus", "TrackedFrame"]


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
    """None in the frame of birth."""
    detection: int | None
    """Row of the associated detection."""
    missed: int
    """Frames since the last detection or confident relocalisation; 0 if in this frame."""


@dataclass(frozen=True, slots=True)
class TrackedFrame:
    """What ``Tracker.finish`` returns: the living tracks by id, and what happened.

    A track that ended in this frame is not among ``tracks``; its event says why. Events: ``born``, ``confirmed``,
    ``missed`` (first frame of a run without evidence), ``died``.
    """

    tracks: tuple[TrackStatus, ...]
    events: tuple[Event, ...]
