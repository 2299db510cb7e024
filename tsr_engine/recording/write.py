"""Writes a recording of a range of frames for the Rerun viewer, from stored evidence."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import EvidenceError
from tsr_engine.evidence.header import VideoIdentity
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.io.atomic import atomic_bytes
from tsr_engine.io.video_probe import video_sha256
from tsr_engine.labels.classes import classes_of_keys
from tsr_engine.labels.files import DEFAULT, shipped_set
from tsr_engine.recording.classes import RecordedClasses
from tsr_engine.recording.clip import Clip, cut_clip
from tsr_engine.recording.content import Frames, TrackSeries
from tsr_engine.recording.from_evidence import read_box_layers, read_events, read_frames, read_track_series
from tsr_engine.recording.recording_data import RecordingData
from tsr_engine.recording.request import RecordingReport, RecordingRequest

__all__ = ["load_sdk", "write_recording"]


def load_sdk() -> None:
    """Import the SDK now, which takes more than a second; if that fails, the next import raises the error."""
    with suppress(ImportError):
        import tsr_engine.recording.rrd_file  # noqa: F401


def write_recording(
    request: RecordingRequest, progress: Callable[[int, int], None] = lambda _done, _of: None
) -> RecordingReport:
    """Write a recording; the file appears complete or not at all.

    Args:
        request: what to record.
        progress: called with (steps done, total); may raise to stop.

    Raises:
        EvidenceError: the run cannot be read, or the video is not the one that was tracked.
        UsageError: the run has not stored these frames, or they are too many for a viewer.
        VideoError: the video cannot be read.
        StorageError: the file cannot be written.
    """
    began = time.perf_counter()
    # Loading the SDK takes up to a second of Python. Cutting pictures, and encoding if needed, runs in parallel with it
    # and with everything else.
    threading.Thread(target=load_sdk, name="tsr-recording-sdk", daemon=True).start()
    with (
        EvidenceReader(request.evidence) as reader,
        ThreadPoolExecutor(1, thread_name_prefix="tsr-recording-picture") as beside,
    ):
        called = request.called or f"the run in {reader.folder}"
        frames = read_frames(reader, request.first, request.stop, called)
        progress(0, 4)
        picture = beside.submit(_picture, request, reader.header.video, called, frames)
        classes = RecordedClasses(request.classes or classes_of_keys(reader.header.labels, shipped_set(DEFAULT)))
        layers = {
            name: rows.with_classes(classes.of_classes(rows.table.class_id)).within(frames)
            for name, rows in read_box_layers(reader, frames, classes)
        }
        for name, rows in (("corrected", request.corrected), ("truth", request.truth)):
            if rows is not None:
                layers[name] = rows.with_classes(classes.of_labels(rows.table.class_id)).within(frames)
        lines = _sort_tracks(list(read_track_series(reader, frames, classes)), request.focus_track)
        moments = read_events(reader, frames)
        progress(1, 4)
        content = RecordingData(request, reader, classes, frames, layers, lines, moments)
        return _write(content, picture, progress, began)


def _picture(request: RecordingRequest, known: VideoIdentity, called: str, frames: Frames) -> tuple[Clip | None, str]:
    """The picture, and one sentence on its source."""
    if request.video is None:
        return None, "There is none, because the recording was made without the video."
    if not request.known and video_sha256(request.video) != known.sha256:
        raise EvidenceError(
            f"{request.video} is not the video of {called}: that was {known.name} with the SHA-256 "
            f"{known.sha256[:12]}... . Name that file."
        )
    clip = cut_clip(request.video, frames, _read_times, table=request.table, limits=request.limits, exact=request.exact)
    return clip, clip.how


def _read_times(clip: bytes) -> NDArray[np.int64]:
    from tsr_engine.recording.rrd_sink import read_video_times

    return read_video_times(clip)


def _sort_tracks(lines: list[TrackSeries], focus: int | None) -> list[TrackSeries]:
    """The focus track, then the tracks with the most values."""
    return sorted(lines, key=lambda one: (one.track_id != focus, -sum(len(v.at) for v in one.values.values())))


def _write(
    content: RecordingData, cut: Future[tuple[Clip | None, str]], progress: Callable[[int, int], None], began: float
) -> RecordingReport:
    from tsr_engine.recording.rrd_file import log_data, log_picture, open_sink

    request, frames = content.request, content.frames
    digest = content.identity()
    application, recording = f"tsr_{digest[:12]}", digest[:32]
    with atomic_bytes(request.out) as file, open_sink(content, application, recording) as sink:
        log_data(content, sink)
        progress(2, 4)
        clip, picture = cut.result()
        log_picture(content, sink, clip, picture)
        progress(3, 4)
        size = file.write(sink.take())
    progress(4, 4)
    return RecordingReport(
        path=request.out,
        recording_id=recording,
        application_id=application,
        name=content.title(),
        first=frames.first,
        stop=frames.first + len(frames),
        size=size,
        picture_size=0 if clip is None else len(clip.data),
        seconds=time.perf_counter() - began,
        picture=picture,
        boxes={name: len(rows) for name, rows in content.layers.items()},
        tracks=tuple(one.track_id for one in content.lines),
        events=len(content.moments.frame),
    )
