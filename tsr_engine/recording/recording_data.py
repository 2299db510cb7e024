"""Gathers the content of a recording from the evidence."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np

from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.recording.classes import RecordedClasses
from tsr_engine.recording.content import BoxRows, EventLog, Frames, TrackSeries
from tsr_engine.recording.request import RecordingRequest


@dataclass(frozen=True, slots=True)
class RecordingData:
    """The content of a recording without its picture."""

    request: RecordingRequest
    reader: EvidenceReader
    classes: RecordedClasses
    frames: Frames
    layers: dict[str, BoxRows]
    track_series: list[TrackSeries]
    events: EventLog

    @property
    def tau(self) -> float:
        """The gate's threshold; NaN: unknown."""
        return float(self.reader.header.parameters.get("gate", {}).get("tau", np.nan))

    def title(self) -> str:
        """The recording's name for people."""
        last = self.frames.first + len(self.frames) - 1
        return self.request.name or f"{self.reader.header.video.name}, frames {self.frames.first} to {last}"

    def identity(self) -> str:
        """Digest of everything that decides the content: a viewer merges recordings with the same name."""
        digest = hashlib.sha256(self.reader.header.identity().encode())
        picture = None if self.request.video is None else self.request.exact
        digest.update(repr((self.frames.first, len(self.frames), picture, self.title())).encode())
        digest.update(repr((self.request.focus_frame, self.request.focus_track, dict(self.request.notes))).encode())
        if self.request.classes is not None:
            digest.update(repr(self.classes.infos).encode())
        for name in ("corrected", "truth"):
            rows = self.layers.get(name)
            if rows is not None:
                columns = rows.table.frame, rows.table.boxes, rows.table.class_id
                digest.update(name.encode() + b"".join(column.tobytes() for column in columns))
                digest.update("\0".join(rows.labels).encode())
        return digest.hexdigest()
