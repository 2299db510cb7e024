"""The evidence folder of a live run: the stored frames of an earlier call, and the writer of new ones."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np

from tsr_engine.errors import EvidenceError
from tsr_engine.evidence import EvidenceReader, EvidenceWriter, RunHeader
from tsr_engine.evidence.schema import RUN_FILE
from tsr_engine.io.video import FrameTable, Video
from tsr_engine.params import Params
from tsr_engine.pipeline import Models, TrackingCore, rebuild_core
from tsr_engine.plural import plural
from tsr_engine.records import FrameEvidence
from tsr_engine.runs.report import RunReport, RunRequest


class RunEvidence:
    """The evidence folder of a run, which a later call can resume.

    Attributes:
        writer: appends frames.
        last_frame: last stored frame of an earlier call; None: no frames.
        interval: time between frames, s. Predictions depend on it, so a resumed run keeps that of the first call.
    """

    def __init__(self, folder: Path, request: RunRequest, header: RunHeader) -> None:
        """Open the folder, or make it.

        Raises:
            EvidenceError: the folder belongs to something else.
            StorageError: the folder cannot be written.
        """
        self._request = request
        if not (folder / RUN_FILE).exists() or request.restart:
            self.writer = EvidenceWriter.create(folder, header, overwrite=request.restart, shared=request.shared)
        else:
            self.writer = EvidenceWriter.resume(folder, header, shared=request.shared)
        self.last_frame = self.writer.last_frame
        self.interval = float(self.writer.header.frame_table["interval"])

    def earlier_frames(self, video: Video) -> Iterator[FrameEvidence]:
        """The stored frames of an earlier call, without pixels; the video takes its frame table from them if possible.

        Raises:
            EvidenceError: the stored frames are not those of this request, or of this video.
        """
        last, start, stop = self.last_frame, self._request.start, self._request.stop
        if last is None:
            return
        with EvidenceReader(self.writer.folder) as reader:
            if reader.first_frame != start:
                raise EvidenceError(
                    f"{self.writer.folder} holds frames from {reader.first_frame} on, expected from {start} on. "
                    "Use the same --frames, or a new folder."
                )
            if stop is not None and last >= stop:
                raise EvidenceError(
                    f"{self.writer.folder} holds frames up to {last}, expected none from {stop} on. "
                    "Use the same --frames, or a new folder."
                )
            time_base = video.table.time_base
            if start == 0 and video.stamps_are_times and not video.adopt(_confirmed_table(reader, time_base)):
                raise EvidenceError(
                    f"The frames in {self.writer.folder} are not those that {self._request.video} has now. "
                    "Track it into a new folder."
                )
            yield from reader.frames(start, last + 1, pixels=False)

    def frames(self) -> Iterator[FrameEvidence] | None:
        """The stored frames of an earlier call; None: no frames."""
        return None if self.last_frame is None else _read(self.writer.folder, self._request.start, self.last_frame + 1)

    def core(self, params: Params, parts: Models, last: int) -> TrackingCore:
        """The run's core as it was after frame ``last``."""
        with EvidenceReader(self.writer.folder) as reader:
            return rebuild_core(reader, params, parts, last)

    def close(self, report: RunReport, failure: BaseException | None) -> None:
        """Store how the run ended, and close the folder.

        Raises:
            StorageError: the remaining data cannot be written.
        """
        if report.interrupted or isinstance(failure, KeyboardInterrupt):
            self.writer.close("interrupted", f"Interrupted after {plural(report.frames, 'frame')}.")
        elif failure is not None:
            self.writer.close("failed", str(failure))
        else:
            self.writer.close("complete", "")


def _confirmed_table(reader: EvidenceReader, time_base: Fraction) -> FrameTable:
    """The decoded frames of a run, from 0 on, as a frame table.

    Rows end before the first frame without a presentation time.
    """
    pts, flags = array("q"), bytearray()
    for _, entry in reader.frame_table():
        if entry.pts is None:
            break
        pts.append(entry.pts)
        flags.append(entry.key | 2 * entry.corrupt)
    stamps, bits = np.array(pts, dtype=np.int64), np.frombuffer(bytes(flags), dtype=np.uint8)
    return FrameTable(time_base, stamps, stamps, (bits & 1) > 0, (bits & 2) > 0, len(stamps), complete=False)


def _read(folder: Path, start: int, stop: int) -> Iterator[FrameEvidence]:
    with EvidenceReader(folder) as reader:
        yield from reader.frames(start, stop, pixels=False)
