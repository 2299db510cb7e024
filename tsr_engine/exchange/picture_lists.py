"""Frames, subsets, names and files of pictures, for all formats that list pictures."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsr_engine.exchange.dataset import Dataset, DatasetVideo
from tsr_engine.exchange.formats import ExportOptions, Switch
from tsr_engine.exchange.frame_rows import FrameRows, rows_by_frame
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.pictures import WrittenPicture, wanted_frames, write_pictures
from tsr_engine.exchange.split import subset_of, subsets_of_frames
from tsr_engine.exchange.video_names import picture_prefixes

IMAGE_SWITCH = Switch(
    "image", ("jpg", "png"), "Format of the pictures; without pictures, the suffix of their names in the file."
)


@dataclass(frozen=True, slots=True)
class PictureList:
    """The pictures of one video that an export lists.

    Attributes:
        video: the video.
        video_index: index of the video in the data set.
        rows: the video's boxes.
        frames: listed frames, ascending: those with a box, and those whose pictures are exported.
        subset: name of the subset of each listed frame.
        prefix: prefix of the pictures' names.
        first_track: number of tracks in earlier videos; ``rows.track`` plus this number is unique in the data set.
        first_frame: number of frames in earlier videos.
    """

    video: DatasetVideo
    video_index: int
    rows: FrameRows
    frames: NDArray[np.int64]
    subset: list[str]
    prefix: str
    first_track: int
    first_frame: int

    def stem(self, frame: int) -> str:
        """Name of a frame's picture without folder and suffix."""
        return f"{self.prefix}frame_{frame:06d}"

    def frames_and_rows(self, subset: str | None = None) -> Iterator[tuple[int, slice]]:
        """The listed frames of a subset (unset: of all), and the slice of their rows."""
        row_ranges = dict(self.rows.table.by_frame())
        no_rows = slice(0, 0)
        for frame, frame_subset in zip(self.frames.tolist(), self.subset, strict=True):
            if subset is None or frame_subset == subset:
                yield frame, row_ranges.get(frame, no_rows)


def make_picture_lists(dataset: Dataset, options: ExportOptions, *, rounding: float | None = None) -> list[PictureList]:
    """Gather each video's boxes by frame, without tracks that are in no subset of the split.

    Args:
        dataset: its tracks are read twice.
        options: pictures, split and thinning.
        rounding: largest rounding error of edges in px, for formats that mark key frames; None: the format does not,
            so all rows count as key frames.
    """
    out: list[PictureList] = []
    tracks = frames_before = 0
    for video_index, (video, prefix) in enumerate(zip(dataset.videos, picture_prefixes(dataset.videos), strict=True)):
        only = None
        if options.split:
            only = {t.uid for t in video.tracks() if subset_of(video, t.uid, options.split) is not None}
        thin_px = 0.0 if rounding is None else options.thin_px
        rows = rows_by_frame(video, thin_px=thin_px, rounding=rounding or 0.0, only=only)
        frames = np.union1d(rows.frames, wanted_frames(video, rows.frames, options.pictures)).astype(np.int64)
        names, subset_of_frame = subsets_of_frames(video, options.split)
        subset = [names[number] for number in subset_of_frame[frames].tolist()]
        out.append(PictureList(video, video_index, rows, frames, subset, prefix, tracks, frames_before))
        tracks += len(rows.tracks)
        frames_before += video.frames
    return out


def write_listed_pictures(
    lists: list[PictureList], out: OutputSink, options: ExportOptions, name: Callable[[PictureList, int, str], str]
) -> list[WrittenPicture]:
    """Write the pictures of all listed frames, if the options ask for pictures.

    Args:
        lists: of all videos.
        out: the export.
        options: has the choice of pictures and the progress.
        name: makes the file name of a frame in a subset.
    """
    if options.pictures == "none":
        return []
    total = sum(len(part.frames) for part in lists)
    written: list[WrittenPicture] = []
    for part in lists:
        names = [name(part, frame, subset) for frame, subset in zip(part.frames.tolist(), part.subset, strict=True)]
        for picture in write_pictures(part.video, part.video_index, part.frames, out, names):
            written.append(picture)
            options.progress(len(written), total)
    return written
