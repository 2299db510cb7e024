"""Runs as a data set for all formats: corrected boxes and their sources.

This module does not load the database, which would take longer than writing a small export; see
:mod:`app.exchange.run_sources`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from app.edits.documents import TrackDoc
from app.errors import Conflict, Invalid
from app.evidence.run_columns import FloatColumn
from app.exchange.frame_rates import exact_rate
from app.exchange.tracks import boxes_beyond, run_tracks
from tsr_engine.errors import EvidenceError, InputError
from tsr_engine.evidence.columns import frame_size
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Skipped, Track
from tsr_engine.exchange.relabel import unite_label_sets
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video import open_video
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.io.video_probe import video_sha256
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.classes import RunClasses, classes_of_keys
from tsr_engine.labels.files import DEFAULT, shipped_set
from tsr_engine.labels.model import LabelSet
from tsr_engine.plural import plural

LABELS = shipped_set(DEFAULT)
"""The label set of a bare evidence folder, and of a new library."""


@dataclass(frozen=True, slots=True)
class VideoInfo:
    """A video without its tracks; see :class:`tsr_engine.exchange.dataset.DatasetVideo`.

    Attributes:
        known: the file, if its name is given, was compared with ``sha256``.
    """

    name: str
    sha256: str
    width: int
    height: int
    frames: int
    rate: Fraction | None
    times: FloatColumn | None
    constant_rate: bool
    path: VideoSource | None
    limits: VideoLimits | None = None
    table: FrameTable | None = None
    pixel_ratio: Fraction = Fraction(1)
    known: bool = False

    def without_tracks(self) -> DatasetVideo:
        """The video without tracks, as the target of an import."""
        values = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "known"}
        return DatasetVideo(**values, tracks=lambda: iter(()), stop=self.frames)


@dataclass(frozen=True, slots=True)
class Source:
    """A run at one moment.

    Attributes:
        folder: its evidence.
        documents: corrections, by key.
        video: its video.
        first: first frame of the run.
        stop: frame after the last.
        origin: ``engine`` or ``imported``.
        provenance: data for the manifest.
        classes: maps the class numbers of its evidence to the label set of its video.
        keys: keys of the wanted tracks; None: all.
    """

    folder: Path
    documents: Mapping[str, TrackDoc]
    video: VideoInfo
    first: int
    stop: int
    origin: str
    provenance: JsonObject
    classes: RunClasses
    keys: frozenset[str] | None = None

    @property
    def labels(self) -> LabelSet:
        """The label set of its video."""
        return self.classes.labels

    @property
    def run_id(self) -> str | None:
        """The run's id in its data folder; None: a bare evidence folder."""
        found = self.provenance["run"].get("id")
        return None if found is None else str(found)

    @property
    def display_name(self) -> str:
        """The run's name in sentences; the path of a folder inside the data folder would tell people nothing."""
        if self.run_id is None:
            return f"the run in {self.folder}"
        name = self.provenance["run"]["name"]
        return f"the run{f' {name!r}' if name else ''} of {self.video.name}"

    def tracks(self) -> Iterator[Track]:
        """Start a new pass over the tracks."""
        frames, to_label = self.video.frames, self.classes.to_label
        return run_tracks(self.folder, self.documents, self.first, self.stop, frames, self.origin, to_label, self.keys)

    def skipped(self) -> tuple[Skipped, ...]:
        """Boxes that people have drawn outside of the run's frames.

        They are left out, because nobody has checked these frames for further signs.
        """
        documents = self.documents
        if self.keys is not None:
            documents = {key: doc for key, doc in documents.items() if key in self.keys}
        outside_boxes = boxes_beyond(documents, self.first, self.stop, self.video.frames)
        if not outside_boxes:
            return ()
        boxes = plural(sum(outside_boxes.values()), "box", "boxes")
        reason = (
            f"They lie outside of frames {self.first} to {self.stop - 1}, the only ones that the run has tracked. "
            "Track the others too, and carry the corrections over."
        )
        return (Skipped(f"{self.video.name}: {boxes} of {plural(len(outside_boxes), 'track')}", reason),)

    def dataset_video(self) -> DatasetVideo:
        """The video with the run's tracks."""
        return replace(
            self.video.without_tracks(),
            tracks=self.tracks,
            first=self.first,
            stop=self.stop,
            provenance=self.provenance,
        )


def dataset_of(sources: Sequence[Source]) -> Dataset:
    """Combine runs to a data set, in their order.

    Raises:
        Invalid: two of them belong to the same video, which no format can hold.
        ExportError: the label sets of their videos are incompatible.
    """
    seen: dict[str, Source] = {}
    for source in sources:
        if source.video.sha256 in seen:
            raise Invalid(
                f"Two of the runs belong to {source.video.name}. Choose one run per video.",
                field="runs",
                code="same_video",
            )
        seen[source.video.sha256] = source
    labels, videos = unite_label_sets([(source.labels, source.dataset_video()) for source in sources])
    return Dataset(labels, videos, tuple(item for source in sources for item in source.skipped()))


def evidence_source(folder: Path, video: Path | None = None) -> Source:
    """Open a bare evidence folder, without corrections.

    Args:
        folder: folder of the run.
        video: its video; needed for pictures, and for times if the run has not read all frames.

    Raises:
        EvidenceError: the evidence is missing or damaged.
        InputError: the video is another one.
        Conflict: the run has no results.
    """
    with EvidenceReader(folder) as reader:
        header = reader.header
        if video is not None and video_sha256(video) != header.video.sha256:
            raise InputError(
                f"{video} is not the video of {folder}, which was made on {header.video.name} "
                f"(SHA-256 {header.video.sha256[:12]}...). Name that file."
            )
        size = frame_size(reader)
        if size is None:
            raise Conflict(f"{folder} has no results to export.", code="no_evidence")
        table: FrameTable | None = None
        if video is not None:
            with open_video(video) as file:
                table, nominal, ratio = file.table, float(file.rate), file.pixel_ratio
            rate, constant = exact_rate(table.pts, table.time_base, nominal)
            times: FloatColumn | None = times_of(table)
            frames = len(table)
        else:
            ratio = Fraction(1)
            frames = max(int(header.frame_table.get("frames", 0)), (reader.last_frame or 0) + 1)
            rate, constant, times = _stored_times(reader, frames)
    video_info = VideoInfo(
        name=header.video.name,
        sha256=header.video.sha256,
        width=size[0],
        height=size[1],
        frames=frames,
        rate=rate,
        times=times,
        constant_rate=constant,
        path=video,
        table=table,
        pixel_ratio=ratio,
        known=True,
    )
    return source_of(folder, {}, video_info, 0, {"name": folder.name, "kind": "engine"})


def source_of(
    folder: Path,
    documents: Mapping[str, TrackDoc],
    video_info: VideoInfo,
    revision: int,
    run_info: JsonObject,
    classes: RunClasses | None = None,
) -> Source:
    """Make a source of a run's evidence and further data.

    Args:
        folder: its evidence.
        documents: corrections, by key.
        video_info: the video.
        revision: number of the newest edit.
        run_info: the manifest's entry of the run, with at least ``name`` and ``kind``.
        classes: maps the class numbers of its evidence to labels; unset: to ``gtsrb-43``.

    Raises:
        EvidenceError: the evidence belongs to another video.
        Conflict: the run has no results.
    """
    with EvidenceReader(folder) as reader:
        header, low, high = reader.header, reader.first_frame, reader.last_frame
        if header.video.sha256 != video_info.sha256:
            raise EvidenceError(f"{folder} belongs to another video ({header.video.name}). Track this one again.")
    if low is None or high is None:
        raise Conflict(f"{run_info['name']} has no results to export.", code="no_evidence")
    provenance = {
        "run": {**run_info, "first": low, "stop": high + 1, "created": header.created},
        "engine_version": header.engine_version,
        "models": dict(header.models),
        "parameters": header.parameters,
        "edit_revision": revision,
        "edited_tracks": len(documents),
        "video_sha256": header.video.sha256,
    }
    origin = "imported" if run_info["kind"] == "imported" else "engine"
    if classes is None:
        classes = classes_of_keys(header.labels, shipped_set(DEFAULT))
    return Source(folder, documents, video_info, low, min(high + 1, video_info.frames), origin, provenance, classes)


def times_of(table: FrameTable) -> FloatColumn:
    """Presentation times of all frames, s."""
    return np.asarray(table.pts.astype(np.float64) * float(table.time_base))


def _stored_times(reader: EvidenceReader, frames: int) -> tuple[Fraction | None, bool, FloatColumn | None]:
    """Rate, whether it is constant, and the times of all frames, if the run has read them."""
    pts_entries = [entry.pts for _, entry in reader.frame_table()]
    try:
        base = Fraction(str(reader.header.frame_table["time_base"]))
    except (KeyError, ValueError, ZeroDivisionError):
        return None, False, None
    pts = np.array([value for value in pts_entries if value is not None], np.int64)
    if len(pts) < max(1, len(pts_entries)):
        return None, False, None
    rate, constant = exact_rate(pts, base, None)
    return rate, constant, pts.astype(np.float64) * float(base) if len(pts) == frames else None
