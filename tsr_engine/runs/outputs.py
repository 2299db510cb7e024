"""The outputs of a live run besides its evidence: result rows as CSV, and the annotated video.

They are opened before the first frame, and hold all results up to the end of the run, even if it fails. The failure of
one does not affect the other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from typing import TextIO

from tsr_engine.errors import ExportError, StorageError, UsageError
from tsr_engine.evidence import RESULT_HEADER, ResultRow, refuse_run_files
from tsr_engine.evidence.schema import RUN_FILE
from tsr_engine.io.atomic import atomic_text, output_path, real_path, refuse_inputs, storage_error
from tsr_engine.io.opened_file import display_path
from tsr_engine.io.overlay import draw
from tsr_engine.io.video import Frame, Video
from tsr_engine.io.video_writer import VideoWriter
from tsr_engine.pipeline import ResultStream, TrackSummary
from tsr_engine.records import FrameEvidence
from tsr_engine.runs.report import RunRequest

_VIDEO_ENDINGS = (".mp4", ".m4v")


def refuse_outputs(request: RunRequest) -> None:
    """Check the names of the outputs before any file is written.

    Raises:
        UsageError: an output is the input, a file of the run's evidence, the other output or a folder of one of them,
            or the annotated video is not named as an MP4.
    """
    outputs = [path for path in (request.csv, request.annotated) if path is not None]
    refuse_inputs(outputs, [display_path(request.video)])
    if request.evidence is not None:
        refuse_run_files(outputs, request.evidence)
    if len({real_path(path) for path in outputs}) < len(outputs):
        raise UsageError(f"Two outputs have the same name {request.csv}. Choose another for one of them.")
    places = [*outputs, *(() if request.evidence is None else (request.evidence / RUN_FILE,))]
    folders = [folder for place in places for folder in place.absolute().parents]
    refuse_inputs(outputs, folders, "the folder of another output")
    if request.annotated is not None and request.annotated.suffix.lower() not in _VIDEO_ENDINGS:
        raise UsageError(f"The annotated video is an MP4: expected a name that ends in .mp4, got {request.annotated}.")


class RunOutputs:
    """Result rows and annotated video of one run, as requested."""

    def __init__(self, request: RunRequest, video: Video, names: Sequence[str]) -> None:
        """Prepare the outputs.

        Args:
            request: request of the run.
            video: the open video.
            names: display name of each class.
        """
        self._request = request
        self._video = video
        self._names = tuple(names)
        self._results = ResultStream()
        self._rows: TextIO | None = None
        self._annotated: VideoWriter | None = None

    def open(self, stack: ExitStack) -> None:
        """Open the files; the stack discards the annotated video unless :meth:`close_video` was called.

        Raises:
            StorageError: a file cannot be written.
            ExportError: the video cannot be encoded.
        """
        if self._request.csv is not None:
            self._rows = stack.enter_context(atomic_text(self._request.csv))
            self._rows.write(RESULT_HEADER + "\n")
        if self._request.annotated is not None:
            path = output_path(self._request.annotated)
            self._annotated = VideoWriter(
                path, self._video.width, self._video.height, self._video.rate, pixel_ratio=self._video.pixel_ratio
            )
            stack.callback(self._annotated.abort)

    @property
    def has_video(self) -> bool:
        """Whether there is an annotated video; it also needs the frames that an earlier call has tracked."""
        return self._annotated is not None

    @property
    def tracks(self) -> list[TrackSummary]:
        """The confirmed tracks that have ended; after :meth:`settle` all of them, by id."""
        return self._results.tracks

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the annotated video."""
        return () if self._annotated is None else self._annotated.warnings

    def add(self, evidence: FrameEvidence) -> None:
        """Add the next frame, and write the rows that are final with it.

        Raises:
            StorageError: the rows cannot be written.
        """
        self._write(self._results.add(evidence))

    def draw(self, frame: Frame, evidence: FrameEvidence) -> None:
        """Add a frame to the annotated video.

        Raises:
            StorageError: the video cannot be written.
        """
        if self._annotated is not None:
            living = replace(evidence, tracks=tuple(track for track in evidence.tracks if track.state != "dead"))
            self._annotated.write(draw(frame.picture, living, self._names), frame.time)

    def finish(self) -> None:
        """Write the remaining rows after the last frame.

        Raises:
            StorageError: the rows cannot be written.
        """
        self._write(self._results.finish())

    def close_video(self, *, failed: bool) -> None:
        """Close the annotated video.

        Args:
            failed: whether the run has failed for another reason; errors of the video are then suppressed.

        Raises:
            StorageError: the video cannot be written, unless ``failed``.
            ExportError: the video cannot be encoded, unless ``failed``.
        """
        if self._annotated is not None:
            with suppress(*((StorageError, ExportError) if failed else ())):
                self._annotated.close()

    def _write(self, rows: Iterator[ResultRow]) -> None:
        for row in rows:
            if self._rows is not None and self._request.csv is not None:
                try:
                    self._rows.write(row.line() + "\n")
                except OSError as error:
                    raise storage_error(self._request.csv, error) from None
