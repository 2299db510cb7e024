"""Cuts signs out and writes the class folders."""

from __future__ import annotations

from typing import TextIO

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Skipped
from tsr_engine.exchange.formats import ExportOptions, Format, Switch, Written
from tsr_engine.exchange.frame_rows import FrameRows, rows_by_frame
from tsr_engine.exchange.gtsrb.reader import SIDECAR, SIDECAR_COLUMNS, read_crops, sniff_crops
from tsr_engine.exchange.labels import benchmark_numbers
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.pictures import encode_picture, picture_sha256, stream_frames
from tsr_engine.exchange.rounding import round_to_pixels
from tsr_engine.exchange.sidecar import ATTRIBUTES_COLUMN, TRACK_COLUMNS, SidecarCells, csv_line
from tsr_engine.exchange.split import subset_of
from tsr_engine.exchange.video_matching import TASK_SWITCH

BORDER_SHARE = 0.1
"""Border as a share of the sign's side."""
MIN_BORDER_PX = 5
"""Smallest border, px."""
_HEADER = "Filename;Width;Height;Roi.X1;Roi.Y1;Roi.X2;Roi.Y2;ClassId\n"
_CROPS_PER_TRACK = 30


def crop_with_border(
    picture: NDArray[np.uint8], box: tuple[int, int, int, int]
) -> tuple[NDArray[np.uint8], tuple[int, int, int, int]]:
    """Crop a sign with its border.

    Args:
        picture: BGR, shape (h, w, 3).
        box: whole px edges inside the picture.

    Returns:
        The crop, and the sign's box within it (edges, the right and lower one exclusive).
    """
    x1, y1, x2, y2 = box
    height, width = picture.shape[:2]
    border_x, border_y = border_px(x2 - x1), border_px(y2 - y1)
    left, top, right, bottom = x1 - border_x, y1 - border_y, x2 + border_x, y2 + border_y
    inside = picture[max(top, 0) : min(bottom, height), max(left, 0) : min(right, width)]
    crop = cv2.copyMakeBorder(
        inside, max(-top, 0), max(bottom - height, 0), max(-left, 0), max(right - width, 0), cv2.BORDER_REPLICATE
    )
    return np.asarray(crop, dtype=np.uint8), (border_x, border_y, border_x + x2 - x1, border_y + y2 - y1)


def border_px(side: int) -> int:
    """Border in px of a side in px: 10 %, at least 5."""
    return max(MIN_BORDER_PX, int(BORDER_SHARE * side + 0.5))


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> Written:
    writer = _Writer(dataset, out, options)
    with out.text(SIDECAR, errors="replace") as sidecar:
        sidecar.write(csv_line([*SIDECAR_COLUMNS, *TRACK_COLUMNS, ATTRIBUTES_COLUMN]) + "\n")
        for video in dataset.videos:
            writer.write_video(video, sidecar)
    writer.write_tables()
    skipped = [
        Skipped(f"{count} {what}", reason)
        for count, what, reason in (
            (writer.without_class, "tracks", "Their label is not one of the 43 classes that GTSRB has folders for."),
            (writer.ignored, "boxes to ignore", "Crops have no such mark."),
            (writer.thinned, "boxes", f"The export takes {_CROPS_PER_TRACK} crops per track (per_track)."),
        )
        if count
    ]
    entries = {
        "roi": "edges within the crop, right and lower one exclusive",
        "border": f"{100 * BORDER_SHARE:.0f} % of the side, at least {MIN_BORDER_PX} px, the edge repeated outside",
        "crops": writer.crops,
        "tracks": SIDECAR,
    }
    return skipped, entries


class _Writer:
    """Cut out frame after frame; the tables follow when all crops are written."""

    def __init__(self, dataset: Dataset, out: OutputSink, options: ExportOptions) -> None:
        self._out = out
        self._numbers = benchmark_numbers(dataset.labels)
        self._options = options
        self._suffix = options.switches.get("picture", "ppm")
        self._max_crops = _CROPS_PER_TRACK if options.switches.get("per_track", "all") != "all" else None
        self._tables: dict[tuple[str, int], list[tuple[str, str]]] = {}
        self._next_track: dict[int, int] = {}
        self._total = sum(len(track.frames) for video in dataset.videos for track in video.tracks())
        self.crops = self.without_class = self.ignored = self.thinned = 0

    def write_video(self, video: DatasetVideo, sidecar: TextIO) -> None:
        rows = rows_by_frame(video, only=self._wanted(video))
        chosen = self._choose(rows)
        numbers = [self._number(info.label) for info in rows.tracks]
        subsets = [subset_of(video, info.uid, self._options.split) or "" for info in rows.tracks]
        boxes = round_to_pixels(rows.table.boxes, video.width, video.height)
        crop_counts = [0] * len(rows.tracks)
        track_cells = SidecarCells(rows)
        row_ranges = {frame: row_range for frame, row_range in rows.table.by_frame() if chosen[row_range].any()}
        frames = np.array(list(row_ranges), dtype=np.int64)
        for frame in stream_frames(video, frames):
            digest = picture_sha256(frame)
            row_range = row_ranges[frame.ordinal]
            for k in range(row_range.start, row_range.stop):
                if not chosen[k]:
                    continue
                number = int(rows.table.track[k])
                name = f"{numbers[number]:05d}_{crop_counts[number]:05d}.{self._suffix}"
                crop_counts[number] += 1
                x1, y1, x2, y2 = (int(edge) for edge in boxes[k])
                crop, roi = crop_with_border(frame.picture, (x1, y1, x2, y2))
                path = self._put(subsets[number], self._numbers[rows.tracks[number].label], name, crop, roi)
                format_cells = [path, video.name, video.sha256, frame.ordinal, x1 - roi[0], y1 - roi[1], digest]
                sidecar.write(f"{csv_line(format_cells)},{track_cells(k)}\n")
                self.crops += 1
                self._options.progress(self.crops, max(self._total, self.crops))

    def write_tables(self) -> None:
        """Write one table for each class and subset, ordered by track, then by time."""
        for (subset, label), lines in sorted(self._tables.items()):
            text = "".join(line for _, line in sorted(lines))
            self._out.put(f"{self._class_folder(subset, label)}/GT-{label:05d}.csv", (_HEADER + text).encode("ascii"))

    def _wanted(self, video: DatasetVideo) -> set[str]:
        wanted: set[str] = set()
        for track in video.tracks():
            if subset_of(video, track.uid, self._options.split) is None:
                continue
            if track.label not in self._numbers:
                self.without_class += 1
            else:
                wanted.add(track.uid)
        return wanted

    def _choose(self, rows: FrameRows) -> NDArray[np.bool_]:
        """Which boxes are cut out: none to ignore, and of each track the wanted number at even distances."""
        chosen = ~rows.table.ignore
        self.ignored += int(rows.table.ignore.sum())
        if self._max_crops is not None:
            for number in range(len(rows.tracks)):
                boxes_of_track = np.flatnonzero(chosen & (rows.table.track == number))
                if len(boxes_of_track) > self._max_crops:
                    keep = np.linspace(0, len(boxes_of_track) - 1, self._max_crops).round().astype(np.int64)
                    chosen[np.delete(boxes_of_track, keep)] = False
                    self.thinned += len(boxes_of_track) - len(keep)
        return chosen

    def _number(self, label: int) -> int:
        """Number of a new track within its class, unique over all videos and subsets."""
        number = self._next_track.get(label, 0)
        self._next_track[label] = number + 1
        return number

    def _class_folder(self, subset: str, label: int) -> str:
        return (f"{subset}/" if self._options.split else "") + f"{label:05d}"

    def _put(self, subset: str, label: int, name: str, crop: NDArray[np.uint8], roi: tuple[int, int, int, int]) -> str:
        path = f"{self._class_folder(subset, label)}/{name}"
        self._out.put(path, encode_picture(crop, f".{self._suffix}"))
        lines = self._tables.setdefault((subset, label), [])
        height, width = crop.shape[:2]
        lines.append((name, f"{name};{width};{height};{';'.join(map(str, roi))};{label}\n"))
        return path


FORMAT = Format(
    name="gtsrb",
    title="GTSRB crops",
    summary="Cropped signs by class and track, for training a classifier.",
    write=_write,
    read=read_crops,
    sniff=sniff_crops,
    export_switches=(
        Switch("picture", ("ppm", "png"), "Format of the crops; both keep every pixel."),
        Switch("per_track", ("all", "30"), "All crops of a track, or 30 evenly chosen ones as in the benchmark."),
    ),
    import_switches=(TASK_SWITCH,),
    needs_pictures=True,
    ignores=False,
    docs="gtsrb.md",
)
