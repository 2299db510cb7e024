"""Writes a recording's content into the Rerun viewer's file. Imports the SDK: see ``write.load_sdk``."""

from __future__ import annotations

import json

import numpy as np

from tsr_engine.recording.about_page import about_text
from tsr_engine.recording.blueprint import PLOT_TITLES, BlueprintInputs, make_blueprint
from tsr_engine.recording.clip import Clip
from tsr_engine.recording.content import Series, TrackSeries
from tsr_engine.recording.from_evidence import MAX_VOTE_CLASSES
from tsr_engine.recording.layers import EVENTS, LAYERS, TAU_COLOUR, TRACK_COLOURS, VIDEO, Rgb, track_entity
from tsr_engine.recording.recording_data import RecordingData
from tsr_engine.recording.rrd_sink import RrdSink

__all__ = ["log_data", "log_picture", "open_sink"]


def open_sink(content: RecordingData, application_id: str, recording_id: str) -> RrdSink:
    """Open a recording that holds only its views."""
    request, frames = content.request, content.frames
    values = frozenset((one.track_id, value) for one in content.lines for value in one.values)
    focus = request.focus_frame
    opening = BlueprintInputs(
        frames.width,
        frames.height,
        tuple(content.layers),
        [one.track_id for one in content.lines],
        values,
        None if focus is None or not frames.first <= focus < frames.first + len(frames) else (focus, focus),
        (frames.first, frames.first + len(frames)),
    )
    return RrdSink(application_id, recording_id, make_blueprint(opening))


def log_data(content: RecordingData, sink: RrdSink) -> None:
    """Log everything except the picture."""
    frames = content.frames
    sink.name(content.title())
    sink.classes(content.classes.infos)
    corrected = content.layers.get("corrected")
    for name, rows in content.layers.items():
        # A result lies below its corrected box, where two labels would be unreadable.
        covered = name == "results" and corrected is not None and len(corrected) > 0
        sink.boxes(LAYERS[name], frames, rows, LAYERS[name].labelled and not covered)
    if np.isfinite(content.tau) and content.tau > 0:
        every = np.full((len(frames), 1), content.tau)
        sink.scalars("gate/tau", frames, Series(frames.ordinal, every, ("tau",)), "gate", [TAU_COLOUR])
        sink.scalars(
            "gate/log10_tau", frames, Series(frames.ordinal, np.log10(every), ("log10 tau",)), "gate", [TAU_COLOUR]
        )
    for order, one in enumerate(content.lines):
        _log_track(one, order, content, sink)
    sink.log_entries(EVENTS, frames, content.moments)


def log_picture(content: RecordingData, sink: RrdSink, clip: Clip | None, picture: str) -> None:
    """Log the picture, if there is one, and the page "About", which names its source."""
    frames, header = content.frames, content.reader.header
    facts = {
        "engine_version": header.engine_version,
        "schema_version": str(header.schema_version),
        "sdk_version": sink.sdk_version,
        "video": header.video.name,
        "video_sha256": header.video.sha256,
        "run_identity": header.identity(),
        "run_created": header.created,
        "frames": f"{frames.first}:{frames.first + len(frames)}",
        "picture": picture,
        "models": json.dumps(dict(header.models), sort_keys=True),
        "configuration": json.dumps(header.parameters, sort_keys=True),
        **content.request.notes,
    }
    sink.properties("tsr", facts)
    sink.document("about", about_text(content.title(), facts, header, {n: len(r) for n, r in content.layers.items()}))
    if clip is not None:
        sink.video(VIDEO, clip.data, frames, clip.nanos)


def _log_track(one: TrackSeries, order: int, content: RecordingData, sink: RrdSink) -> None:
    frames, title = content.frames, f"#{one.track_id} {content.classes.short(one.class_id)}"
    for value, series in one.values.items():
        shown = title if value in PLOT_TITLES else ""
        sink.scalars(track_entity(one.track_id, value), frames, series, shown, _colours(order, value, series))
    sink.states(track_entity(one.track_id, "state"), frames, *one.states)


def _colours(order: int, value: str, series: Series) -> list[Rgb]:
    """Line colours of one value of the track at this index, different from its neighbours'."""
    width = series.values.shape[1]
    first = order * (MAX_VOTE_CLASSES if value == "votes" else width)
    return [TRACK_COLOURS[(first + line) % len(TRACK_COLOURS)] for line in range(width)]
