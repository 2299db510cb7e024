"""Copies a range of frames of an evidence store into a new store."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from tsr_engine.evidence import EvidenceReader, EvidenceWriter, RunHeader
from tsr_engine.evidence.schema import LOCK_FILE
from tsr_engine.json_shapes import JsonObject
from tsr_engine.records import Event, FrameEvidence, TrackFrame


def write_slice(
    reader: EvidenceReader,
    folder: Path,
    start: int,
    stop: int,
    header: RunHeader,
    *,
    offset: int = 0,
    on_frame: Callable[[FrameEvidence], object] = lambda _frame: None,
) -> None:
    """Write the frames ``start <= k < stop``.

    Args:
        reader: the store.
        folder: folder of the new store.
        start: first frame.
        stop: frame after the last.
        header: header of the new store.
        offset: subtracted from every frame number.
        on_frame: called with each frame when it is written.
    """
    with EvidenceWriter.create(folder, header, chunk=64, overwrite=True) as writer:
        for frame, (_, entry) in zip(reader.frames(start, stop), reader.frame_table(start, stop), strict=True):
            shifted = shift_frame(frame, offset) if offset else frame
            # Pictures of a clip have other times; the times that the engine got stay in ``seconds``.
            writer.append(shifted, replace(entry, pts=None) if offset else entry)
            on_frame(shifted)
    (folder / LOCK_FILE).unlink(missing_ok=True)


def shift_frame(frame: FrameEvidence, offset: int) -> FrameEvidence:
    """The frame's evidence with every frame number lowered by ``offset``."""
    return replace(
        frame,
        ordinal=frame.ordinal - offset,
        tracks=tuple(_shift_track(track, offset) for track in frame.tracks),
        events=tuple(_shift_event(event, offset) for event in frame.events),
    )


def _shift_track(track: TrackFrame, offset: int) -> TrackFrame:
    # Offline samples come from no frame.
    samples = (s if s.frame < 0 else replace(s, frame=max(0, s.frame - offset)) for s in track.samples)
    return replace(track, samples=tuple(samples))


def _shift_event(event: Event, offset: int) -> Event:
    if "frame" not in event.values:
        return event
    values: JsonObject = dict(event.values)
    if isinstance(values["frame"], int):
        values["frame"] -= offset
    return replace(event, values=values)
