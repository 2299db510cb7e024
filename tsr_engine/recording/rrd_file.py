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


def open_sink(data: RecordingData, application_id: str, recording_id: str) -> RrdSink:
    """Open a recording that holds only its views."""
    request, frames = data.request, data.frames
    values = frozenset((series.track_id, value) for series in data.track_series for value in series.values)
    focus = request.focus_frame
    blueprint_inputs = BlueprintInputs(
        frames.width,
        frames.height,
        tuple(data.layers),
        [series.track_id for series in data.track_series],
        values,
        None if focus is None or not frames.first <= focus < frames.first + len(frames) else (focus, focus),
        (frames.first, frames.first + len(frames)),
    )
    return RrdSink(application_id, recording_id, make_blueprint(blueprint_inputs))


def log_data(data: RecordingData, sink: RrdSink) -> None:
    """Log everything except the picture."""
    frames = data.frames
    sink.name(data.title())
    sink.classes(data.classes.infos)
    corrected = data.layers.get("corrected")
    for name, rows in data.layers.items():
        # A result lies below its corrected box, where two labels would be unreadable.
        is_covered = name == "results" and corrected is not None and len(corrected) > 0
        sink.boxes(LAYERS[name], frames, rows, LAYERS[name].labelled and not is_covered)
    if np.isfinite(data.tau) and data.tau > 0:
        tau_column = np.full((len(frames), 1), data.tau)
        sink.scalars("gate/tau", frames, Series(frames.ordinal, tau_column, ("tau",)), "gate", [TAU_COLOUR])
        sink.scalars(
            "gate/log10_tau", frames, Series(frames.ordinal, np.log10(tau_column), ("log10 tau",)), "gate", [TAU_COLOUR]
        )
    for order, track in enumerate(data.track_series):
        _log_track(track, order, data, sink)
    sink.log_entries(EVENTS, frames, data.events)


def log_picture(data: RecordingData, sink: RrdSink, clip: Clip | None, picture: str) -> None:
    """Log the picture, if there is one, and the page "About", which names its source."""
    frames, header = data.frames, data.reader.header
    properties = {
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
        **data.request.notes,
    }
    sink.properties("tsr", properties)
    sink.document("about", about_text(data.title(), properties, header, {n: len(r) for n, r in data.layers.items()}))
    if clip is not None:
        sink.video(VIDEO, clip.data, frames, clip.times_ns)


def _log_track(track: TrackSeries, order: int, data: RecordingData, sink: RrdSink) -> None:
    frames, title = data.frames, f"#{track.track_id} {data.classes.short_name(track.class_id)}"
    for value, series in track.values.items():
        shown = title if value in PLOT_TITLES else ""
        sink.scalars(track_entity(track.track_id, value), frames, series, shown, _colours(order, value, series))
    sink.states(track_entity(track.track_id, "state"), frames, *track.states)


def _colours(order: int, value: str, series: Series) -> list[Rgb]:
    """Line colours of one value of the track at this index, different from its neighbours'."""
    width = series.values.shape[1]
    first = order * (MAX_VOTE_CLASSES if value == "votes" else width)
    return [TRACK_COLOURS[(first + line) % len(TRACK_COLOURS)] for line in range(width)]
