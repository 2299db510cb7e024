"""Converts columns to the bytes of a ``.rrd`` file; only this module writes with the Rerun SDK.

The SDK takes more than a second to import, so this module is imported only to make a recording.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from types import TracebackType

import numpy as np
import rerun as rr
from rerun.blueprint import Blueprint

from tsr_engine.json_shapes import JsonObject
from tsr_engine.recording.content import BoxRows, EventLog, Frames, Series
from tsr_engine.recording.layers import FRAME_TIMELINE, TIME_TIMELINE, VIDEO, Layer, Rgb
from tsr_engine.track_table import IntArray

_MAX_LINE_WIDTH = 44
"""Longest line in the event log, in characters."""
_LEVELS = {"rejected": "WARN", "missed": "WARN", "died": "INFO", "relabelled": "WARN"}
_STATE_COLOURS = {"detected": 0x56B4E9FF, "predicted": 0xF0E442FF, "relocalised": 0xE69F00FF}


def read_video_times(data: bytes) -> IntArray:
    """Presentation times in ns of all pictures of an MP4 file as the viewer reads them."""
    stamps = rr.AssetVideo(contents=data, media_type="video/mp4").read_frame_timestamps_nanos()
    return np.asarray(stamps, np.int64)


class RrdSink:
    """An open recording, collected in memory; a context manager.

    The SDK can write files itself, but on a full disk it waits for its writing thread for ever.
    """

    def __init__(self, application_id: str, recording_id: str, blueprint: Blueprint) -> None:
        self._strict = rr.strict_mode()
        rr.set_strict_mode(True)  # otherwise data of a wrong shape is dropped with a warning
        self._recording = rr.RecordingStream(application_id, recording_id=recording_id)
        self._memory = self._recording.memory_recording()
        # In memory the blueprint comes after the recording's first chunk. By then a viewer has arranged its views,
        # and keeps them unless the blueprint is made the active one.
        self._recording.send_blueprint(blueprint, make_active=True, make_default=True)

    def __enter__(self) -> RrdSink:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        rr.set_strict_mode(self._strict)
        self._recording.disconnect()

    def to_bytes(self) -> bytes:
        """The whole recording as a ``.rrd`` file with its index at the end; the sink is empty afterwards."""
        return bytes(self._memory.drain_as_bytes())

    @property
    def sdk_version(self) -> str:
        """Version of the SDK; viewers of the same version show the recording."""
        return str(rr.__version__)

    def name(self, title: str) -> None:
        """Name the recording for people."""
        self._recording.send_recording_name(title)

    def properties(self, name: str, values: dict[str, str]) -> None:
        """Log facts about the recording."""
        self._recording.send_property(name, rr.AnyValues(**values))  # type: ignore[arg-type]

    def document(self, entity: str, markdown: str) -> None:
        """Log a page of text."""
        self._static(entity, rr.TextDocument(markdown, media_type="text/markdown"))

    def classes(self, infos: list[tuple[int, str, Rgb]]) -> None:
        """Log numbers, names and colours of the labels for everything below the picture."""
        self._static(VIDEO, rr.AnnotationContext(infos))

    def video(self, entity: str, data: bytes, frames: Frames, times_ns: IntArray) -> None:
        """Log the clip, and the picture of each frame."""
        self._static(entity, rr.AssetVideo(contents=data, media_type="video/mp4"))
        self._columns(entity, frames, frames.ordinal, rr.VideoFrameReference.columns_nanos(times_ns))

    def boxes(self, layer: Layer, frames: Frames, rows: BoxRows, labelled: bool) -> None:
        """Log boxes of a layer, and clear frames without boxes. Unlabelled boxes show their label under the pointer."""
        boxes = rows.table.boxes
        centres, halves = (boxes[:, :2] + boxes[:, 2:]) / 2, (boxes[:, 2:] - boxes[:, :2]) / 2
        counts = rows.counts(frames)
        columns: JsonObject = {"centers": centres, "half_sizes": halves, "labels": list(rows.labels)}
        columns["class_ids"] = rows.table.class_id.astype(np.uint16)
        self._columns(layer.entity, frames, frames.ordinal, rr.Boxes2D.columns(**columns).partition(counts))
        style: JsonObject = {"radii": [-layer.radius], "show_labels": labelled}
        if layer.colour is not None:
            style["colors"] = [layer.colour]
        self._static(layer.entity, rr.Boxes2D.from_fields(**style))

    def scalars(self, entity: str, frames: Frames, series: Series, title: str, colours: list[Rgb]) -> None:
        """Log values over time; the title names the lines, and lines without a title are hidden at first."""
        columns = rr.Scalars.columns(scalars=series.values.ravel())
        self._columns(entity, frames, series.at, columns.partition([series.values.shape[1]] * len(series.at)))
        if title:
            names = [f"{title} {name}" for name in series.names]
            self._static(entity, rr.SeriesLines(names=names, colors=colours))

    def states(self, entity: str, frames: Frames, at: IntArray, states: tuple[str, ...]) -> None:
        """Log the states of a track where they change."""
        self._columns(entity, frames, at, rr.StateChange.columns(state=list(states)))
        colours = np.array(list(_STATE_COLOURS.values()), np.uint32)
        self._static(entity, rr.StateConfiguration(values=list(_STATE_COLOURS), colors=colours))

    def log_entries(self, entity: str, frames: Frames, events: EventLog) -> None:
        """Log the events."""
        if len(events.frame):
            levels = [_LEVELS.get(kind, "INFO") for kind in events.kind]
            # The viewer's log does not wrap lines.
            texts = [textwrap.fill(text, _MAX_LINE_WIDTH, break_on_hyphens=False) for text in events.text]
            self._columns(entity, frames, events.frame, rr.TextLog.columns(text=texts, level=levels))

    def _static(self, entity: str, content: rr.AsComponents) -> None:
        self._recording.log(entity, content, static=True)

    def _columns(self, entity: str, frames: Frames, at: IntArray, columns: Iterable[rr.ComponentColumn]) -> None:
        indexes = [
            rr.TimeColumn(FRAME_TIMELINE, sequence=at),
            rr.TimeColumn(TIME_TIMELINE, duration=frames.seconds_at(at)),
        ]
        self._recording.send_columns(entity, indexes=indexes, columns=columns)
