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
from tsr_engine.recording.content import Frames
from tsr_engine.recording.from_evidence import read_box_layers, read_events, read_frames, read_track_series
from tsr_engine.recording.recording_data import RecordingData
from tsr_engine.recording.request import RecordingReport, RecordingRequest


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
    start_time = time.perf_counter()
    # Loading the SDK takes up to a second of Python. Cutting pictures, and encoding if needed, runs in parallel with it
    # and with everything else.
    threading.Thread(target=load_sdk, name="tsr-recording-sdk", daemon=True).start()
    with (
        EvidenceReader(request.evidence) as reader,
        ThreadPoolExecutor(1, thread_name_prefix="tsr-recording-picture") as executor,
    ):
        run_name = request.called or f"the run in {reader.folder}"
        frames = read_frames(reader, request.first, request.stop, run_name)
        progress(0, 4)
        picture = executor.submit(_picture, request, reader.header.video, run_name, frames)
        classes = RecordedClasses(request.classes or classes_of_keys(reader.header.labels, shipped_set(DEFAULT)))
        layers = {
            name: rows.with_classes(classes.of_classes(rows.table.class_id)).in_frames(frames)
            for name, rows in read_box_layers(reader, frames, classes)
        }
        for name, rows in (("corrected", request.corrected), ("truth", request.truth)):
            if rows is not None:
                layers[name] = rows.with_classes(classes.of_labels(rows.table.class_id)).in_frames(frames)
        # The focus track, then the tracks with the most values.
        track_series = sorted(
            read_track_series(reader, frames, classes),
            key=lambda track: (track.track_id != request.focus_track, -sum(len(v.at) for v in track.values.values())),
        )
        events = read_events(reader, frames)
        progress(1, 4)
        data = RecordingData(request, reader, classes, frames, layers, track_series, events)
        return _write(data, picture, progress, start_time)


def _picture(
    request: RecordingRequest, identity: VideoIdentity, run_name: str, frames: Frames
) -> tuple[Clip | None, str]:
    """The picture, and one sentence on its source."""
    if request.video is None:
        return None, "There is none, because the recording was made without the video."
    if not request.known and video_sha256(request.video) != identity.sha256:
        raise EvidenceError(
            f"{request.video} is not the video of {run_name}: that was {identity.name} with the SHA-256 "
            f"{identity.sha256[:12]}... . Name that file."
        )
    clip = cut_clip(request.video, frames, _read_times, table=request.table, limits=request.limits, exact=request.exact)
    return clip, clip.how


def _read_times(clip: bytes) -> NDArray[np.int64]:
    from tsr_engine.recording.rrd_sink import read_video_times

    return read_video_times(clip)


def _write(
    data: RecordingData,
    picture_future: Future[tuple[Clip | None, str]],
    progress: Callable[[int, int], None],
    start_time: float,
) -> RecordingReport:
    from tsr_engine.recording.rrd_file import log_data, log_picture, open_sink

    request, frames = data.request, data.frames
    digest = data.identity()
    application, recording = f"tsr_{digest[:12]}", digest[:32]
    with atomic_bytes(request.out) as file, open_sink(data, application, recording) as sink:
        log_data(data, sink)
        progress(2, 4)
        clip, picture = picture_future.result()
        log_picture(data, sink, clip, picture)
        progress(3, 4)
        size = file.write(sink.to_bytes())
    progress(4, 4)
    return RecordingReport(
        path=request.out,
        recording_id=recording,
        application_id=application,
        name=data.title(),
        first=frames.first,
        stop=frames.first + len(frames),
        size=size,
        picture_size=0 if clip is None else len(clip.data),
        seconds=time.perf_counter() - start_time,
        picture=picture,
        boxes={name: len(rows) for name, rows in data.layers.items()},
        tracks=tuple(one.track_id for one in data.track_series),
        events=len(data.events.frame),
    )
