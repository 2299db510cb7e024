"""One recording of one range of frames, from stored evidence, for the Rerun viewer."""

from __future__ import annotations

import hashlib
import json
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tsr_engine.errors import EvidenceError
from tsr_engine.evidence.header import VideoIdentity
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.io.atomic import atomic_bytes
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.io.video_probe import video_sha256
from tsr_engine.labels.classes import RunClasses, classes_of_keys
from tsr_engine.labels.files import DEFAULT, shipped_set
from tsr_engine.recording.about import about_text
from tsr_engine.recording.blueprint import PLOTTED, Opening, make_blueprint
from tsr_engine.recording.classes import RecordedClasses
from tsr_engine.recording.clip import Clip, cut_clip
from tsr_engine.recording.content import BoxRows, Frames, Lines, Moments, Series
from tsr_engine.recording.layers import EVENTS, LAYERS, TAU_COLOUR, TRACK_COLOURS, VIDEO, Rgb, track_entity
from tsr_engine.recording.sink import Sink, load_sdk, video_stamps
from tsr_engine.recording.stored import LEADING, box_layers, events, frames_of, track_lines

__all__ = ["RecordingReport", "RecordingRequest", "write_recording"]


@dataclass(frozen=True, slots=True)
class RecordingRequest:
    """What to record.

    Attributes:
        evidence: folder of the run.
        out: the ``.rrd`` file; one that is there is replaced.
        first: first frame; unset: the run's first.
        stop: frame after the last; unset: after the run's last.
        video: the video that was tracked; unset: no picture.
        table: its frame table, if it is at hand.
        known: the caller has just made sure that it is the video that was tracked; a large one takes long to hash.
        exact: take the video's own packets over, however many bytes they are.
        corrected: the annotation as people have corrected it.
        truth: ground truth.
        focus_frame: the frame that it is about; marked on the time panel.
        focus_track: the track that it is about; its lines come first.
        name: for people; unset: made from video and frames.
        notes: further facts for the page "About".
        called: what a refusal calls the run, in the middle of a sentence; unset: by its folder.
        limits: what the video may demand; unset: ``VideoLimits()``.
        classes: what the run's class numbers mean in a label set, of which ``corrected`` and ``truth`` have ids; unset:
            in ``gtsrb-43``.
    """

    evidence: Path
    out: Path
    first: int | None = None
    stop: int | None = None
    video: VideoSource | None = None
    table: FrameTable | None = None
    known: bool = False
    exact: bool = False
    corrected: BoxRows | None = None
    truth: BoxRows | None = None
    focus_frame: int | None = None
    focus_track: int | None = None
    name: str = ""
    notes: Mapping[str, str] = field(default_factory=dict)
    called: str = ""
    limits: VideoLimits | None = None
    classes: RunClasses | None = None


@dataclass(frozen=True, slots=True)
class RecordingReport:
    """What was recorded.

    Attributes:
        path: the file.
        recording_id: name by which viewers know it; equal content has an equal one.
        application_id: the other part of that name.
        name: for people.
        first: first frame.
        stop: frame after the last.
        size: bytes.
        picture_size: bytes of its pictures.
        seconds: that writing it took, without loading this program.
        picture: where the picture comes from, or why there is none.
        boxes: layer -> number of boxes.
        tracks: tracks with lines.
        events: entries of the event log.
    """

    path: Path
    recording_id: str
    application_id: str
    name: str
    first: int
    stop: int
    size: int
    picture_size: int
    seconds: float
    picture: str
    boxes: dict[str, int]
    tracks: tuple[int, ...]
    events: int


def write_recording(
    request: RecordingRequest, progress: Callable[[int, int], None] = lambda _done, _of: None
) -> RecordingReport:
    """Write a recording; the file appears whole or not at all.

    Args:
        request: what to record.
        progress: told (steps done, of how many); may raise to stop.

    Raises:
        EvidenceError: the run cannot be read, or the video is not the one that was tracked.
        UsageError: the run has not stored these frames, or they are too many for a viewer.
        VideoError: the video cannot be read.
        StorageError: the file cannot be written.
    """
    began = time.perf_counter()
    # Loading the SDK takes up to a second of Python. Pictures are cut, and at times encoded, beside it and everything
    # else.
    threading.Thread(target=load_sdk, name="tsr-recording-sdk", daemon=True).start()
    with (
        EvidenceReader(request.evidence) as reader,
        ThreadPoolExecutor(1, thread_name_prefix="tsr-recording-picture") as beside,
    ):
        called = request.called or f"the run in {reader.folder}"
        frames = frames_of(reader, request.first, request.stop, called)
        progress(0, 4)
        picture = beside.submit(_picture, request, reader.header.video, called, frames)
        classes = RecordedClasses(request.classes or classes_of_keys(reader.header.labels, shipped_set(DEFAULT)))
        layers = {
            name: rows.with_classes(classes.of_classes(rows.table.class_id)).within(frames)
            for name, rows in box_layers(reader, frames, classes)
        }
        for name, rows in (("corrected", request.corrected), ("truth", request.truth)):
            if rows is not None:
                layers[name] = rows.with_classes(classes.of_labels(rows.table.class_id)).within(frames)
        lines = _ordered(list(track_lines(reader, frames, classes)), request.focus_track)
        moments = events(reader, frames)
        progress(1, 4)
        content = _Content(request, reader, classes, frames, layers, lines, moments)
        return _write(content, picture, progress, began)


@dataclass(frozen=True, slots=True)
class _Content:
    request: RecordingRequest
    reader: EvidenceReader
    classes: RecordedClasses
    frames: Frames
    layers: dict[str, BoxRows]
    lines: list[Lines]
    moments: Moments

    @property
    def tau(self) -> float:
        return float(self.reader.header.parameters.get("gate", {}).get("tau", np.nan))

    def title(self) -> str:
        last = self.frames.first + len(self.frames) - 1
        return self.request.name or f"{self.reader.header.video.name}, frames {self.frames.first} to {last}"

    def identity(self) -> str:
        """Digest of everything that decides what is shown: a viewer merges recordings of one name."""
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


def _picture(request: RecordingRequest, known: VideoIdentity, called: str, frames: Frames) -> tuple[Clip | None, str]:
    """The picture, and one sentence: where it is from."""
    if request.video is None:
        return None, "None: the recording was made without the video."
    if not request.known and video_sha256(request.video) != known.sha256:
        raise EvidenceError(
            f"{request.video} is not the video of {called}: that was {known.name} with the SHA-256 "
            f"{known.sha256[:12]}... . Name that file."
        )
    clip = cut_clip(
        request.video, frames, video_stamps, table=request.table, limits=request.limits, exact=request.exact
    )
    return clip, clip.how


def _ordered(lines: list[Lines], focus: int | None) -> list[Lines]:
    """The track that it is about, then those with the most to see."""
    return sorted(lines, key=lambda one: (one.track_id != focus, -sum(len(v.at) for v in one.values.values())))


def _write(
    content: _Content, cut: Future[tuple[Clip | None, str]], progress: Callable[[int, int], None], began: float
) -> RecordingReport:
    request, frames = content.request, content.frames
    digest = content.identity()
    application, recording = f"tsr_{digest[:12]}", digest[:32]
    values = frozenset((one.track_id, value) for one in content.lines for value in one.values)
    focus = request.focus_frame
    opening = Opening(
        frames.width,
        frames.height,
        tuple(content.layers),
        [one.track_id for one in content.lines],
        values,
        None if focus is None or not frames.first <= focus < frames.first + len(frames) else (focus, focus),
        (frames.first, frames.first + len(frames)),
    )
    with atomic_bytes(request.out) as file, Sink(application, recording, make_blueprint(opening)) as sink:
        _log(content, sink)
        progress(2, 4)
        clip, picture = cut.result()
        _log_picture(content, sink, clip, picture)
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


def _log(content: _Content, sink: Sink) -> None:
    """Everything that needs no picture."""
    frames = content.frames
    sink.name(content.title())
    sink.classes(content.classes.infos)
    corrected = content.layers.get("corrected")
    for name, rows in content.layers.items():
        # a result lies under its corrected box, where two labels cannot be read
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


def _log_picture(content: _Content, sink: Sink, clip: Clip | None, picture: str) -> None:
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


def _log_track(one: Lines, order: int, content: _Content, sink: Sink) -> None:
    frames, title = content.frames, f"#{one.track_id} {content.classes.short(one.class_id)}"
    for value, series in one.values.items():
        shown = title if value in PLOTTED else ""
        sink.scalars(track_entity(one.track_id, value), frames, series, shown, _colours(order, value, series))
    sink.states(track_entity(one.track_id, "state"), frames, *one.states)


def _colours(order: int, value: str, series: Series) -> list[Rgb]:
    """Colours of the lines of one value of the track in that place of the order, other ones than its neighbours'."""
    width = series.values.shape[1]
    first = order * (LEADING if value == "votes" else width)
    return [TRACK_COLOURS[(first + line) % len(TRACK_COLOURS)] for line in range(width)]
