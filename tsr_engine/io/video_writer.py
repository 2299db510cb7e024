"""Writes videos atomically: H.264 in MP4."""

from __future__ import annotations

import errno
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from av.container import OutputContainer
from av.video.reformatter import ColorRange, Colorspace

from tsr_engine.errors import ExportError, StorageError, UsageError
from tsr_engine.io.storage_problems import TOO_LARGE_MESSAGE, full_disk_reason, storage_problem
from tsr_engine.io.unfinished import UnfinishedFile
from tsr_engine.io.video_probe import error_reason
from tsr_engine.plural import plural
from tsr_engine.records import Picture

_TICKS_PER_SECOND = 90_000
_STORAGE_ERRNOS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS, errno.EACCES, errno.EPERM)
# MP4 has 32 signed bits for the distance between a picture's time and its place in the file, which is up to four
# pictures more if pictures are predicted from later ones.
MAX_GAP_TICKS = 2**28


class VideoWriter:
    """Writes pictures to an MP4 that any player shows (H.264, yuv420p).

    Equal pictures give equal bytes. A context manager: the file appears under its name, complete and on the disk, when
    the block ends; an exception leaves nothing behind. Odd sizes grow by one row or column, a copy of the last. Gaps in
    time are cut to 49 minutes, the most that the clock of an MP4 holds between two pictures.

    Attributes:
        path: the file.
        width: px of the pictures.
        height: px of the pictures.
        rate: frames per second.
        frames: number of pictures written.
        cut_gaps: number of gaps between pictures that were cut.
    """

    def __init__(
        self,
        path: Path | str,
        width: int,
        height: int,
        rate: Fraction,
        *,
        crf: int = 20,
        preset: str = "veryfast",
        key_distance: int | None = None,
        pixel_ratio: Fraction = Fraction(1),
    ) -> None:
        """Start a video.

        Args:
            path: the new file; an older one is replaced only at the end.
            width: px of the pictures.
            height: px of the pictures.
            rate: frames per second, announced and used if ``write`` gets no time.
            crf: H.264 constant rate factor, 0 (lossless) to 51; 20 looks like the original.
            preset: effort of x264 per picture: ``ultrafast`` to ``veryslow``.
            key_distance: pictures from one key frame to the next, without B pictures; unset: x264 decides.
            pixel_ratio: width of a pixel divided by its height, for players.

        Raises:
            UsageError: an impossible size or rate.
            StorageError: the folder cannot be written.
        """
        if width < 1 or height < 1 or rate <= 0 or not 0 <= crf <= 51:
            raise UsageError(
                "A video needs a size and a rate above 0 and crf in 0..51. "
                f"Got {width}x{height}, {rate} frames per second, crf {crf}."
            )
        self.path = Path(path)
        self.width, self.height, self.rate = width, height, Fraction(rate)
        self.frames = 0
        self.cut_gaps = 0
        self._first: Fraction | None = None
        self._last_tick = -1
        self._cut_ticks = 0
        try:
            self._unfinished = UnfinishedFile(self.path)
            self._sink = _Sink(self._unfinished.path)
        except OSError as error:
            raise self._storage_error(error) from None
        self._container: OutputContainer | None = av.open(self._sink, mode="w", format="mp4")
        # Otherwise x264's code for AVX-512 reads memory beyond the macroblocks, and bytes differ from run to run.
        options = {"crf": str(crf), "preset": preset, "x264-params": "cpu-independent=1"}
        if key_distance is not None:
            options |= {"g": str(key_distance), "bf": "0"}
            options["x264-params"] += f":keyint={key_distance}:scenecut=0"
        self._stream = self._container.add_stream("libx264", rate=self.rate.limit_denominator(100_000), options=options)
        self._stream.width, self._stream.height = width + width % 2, height + height % 2
        self._stream.pix_fmt = "yuv420p"
        self._stream.codec_context.time_base = Fraction(1, _TICKS_PER_SECOND)
        self._stream.codec_context.sample_aspect_ratio = pixel_ratio
        # State the conversion from BGR: players assume BT.709 for untagged HD and shift its colours.
        self._stream.codec_context.colorspace = Colorspace.ITU601.value
        self._stream.codec_context.color_range = ColorRange.MPEG.value
        # The number of threads changes the bytes that x264 writes.
        self._stream.codec_context.thread_count = 2

    def __enter__(self) -> VideoWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.close()
        else:
            self.abort()

    def write(self, picture: Picture, time: Fraction | None = None) -> None:
        """Append one picture.

        Args:
            picture: BGR, uint8, of the writer's height and width.
            time: display time in s, later than the one before. Unset: by the rate.

        Raises:
            UsageError: another shape or type of picture, or a closed writer.
            StorageError: the disk is full.
            ExportError: the picture cannot be encoded.
        """
        if self._container is None:
            raise UsageError(f"The video {self.path} is closed. Open a new VideoWriter.")
        if picture.shape != (self.height, self.width, 3) or picture.dtype != np.uint8:
            raise UsageError(
                f"Expected a picture of shape {(self.height, self.width, 3)} and type uint8 for {self.path}. "
                f"Got {picture.shape} and {picture.dtype}."
            )
        display_time = self.frames / self.rate if time is None else Fraction(time)
        self._first = display_time if self._first is None else self._first
        tick = self._tick(round((display_time - self._first) * _TICKS_PER_SECOND))
        if self.width % 2 or self.height % 2:
            picture = np.pad(picture, ((0, self.height % 2), (0, self.width % 2), (0, 0)), mode="edge")
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="bgr24")
        frame.pts, frame.time_base = tick, Fraction(1, _TICKS_PER_SECOND)
        self._mux(self._container, frame)
        self._last_tick = tick
        self.frames += 1

    @property
    def warnings(self) -> tuple[str, ...]:
        """One sentence for each difference between the file and the written pictures."""
        if not self.cut_gaps:
            return ()
        gaps = plural(self.cut_gaps, "gap")
        max_minutes = MAX_GAP_TICKS // _TICKS_PER_SECOND // 60
        return (f"{self.path.name} has {gaps} in time cut to {max_minutes} minutes, which is what an MP4 can hold.",)

    def _tick(self, wanted_tick: int) -> int:
        """The display time of a picture wanted at ``wanted_tick``, in ticks after the first picture."""
        tick = max(self._last_tick + 1, wanted_tick - self._cut_ticks)
        excess = tick - self._last_tick - MAX_GAP_TICKS
        if self.frames and excess > 0:
            self.cut_gaps += 1
            self._cut_ticks += excess
            tick -= excess
        return tick

    def close(self) -> None:
        """Finish and publish the file; closing twice is harmless.

        Raises:
            StorageError: the disk is full; nothing is left behind.
            ExportError: the last pictures cannot be encoded; nothing is left behind.
        """
        if self._container is None:
            return
        if not self.frames:
            self.abort()
            return
        self._mux(self._container, None)
        try:
            self._container.close()
            self._sink.finish()
            self._unfinished.commit()
        except (av.FFmpegError, OSError) as error:
            raise self._fail(error) from None
        self._container = None

    def abort(self) -> None:
        """Discard the file; harmless after ``close``."""
        if self._container is None:
            return
        container, self._container = self._container, None
        self._sink.discard = True
        try:
            container.close()
        except (av.FFmpegError, OSError):
            pass
        finally:
            self._sink.close()
            self._unfinished.drop()

    def _mux(self, container: OutputContainer, frame: av.VideoFrame | None) -> None:
        try:
            container.mux(self._stream.encode(frame))
            if self._sink.error is not None:
                raise self._sink.error
        except (av.FFmpegError, OSError) as error:
            raise self._fail(error) from None

    def _fail(self, error: Exception) -> StorageError | ExportError:
        """Discard the file and find the cause: all writes to the disk go through the sink."""
        cause = self._sink.error or error
        self.abort()
        if isinstance(cause, av.FFmpegError) and cause.errno not in _STORAGE_ERRNOS:
            return ExportError(
                f"The pictures cannot be written as the video {self.path}: {error_reason(cause)}. Look for odd sizes "
                "or times in what they come from, or leave the video out."
            )
        return self._storage_error(cause)

    def _storage_error(self, error: BaseException) -> StorageError:
        kind = storage_problem(error)
        if kind == "full":
            reason = full_disk_reason(error)
            return StorageError(
                f"{reason.capitalize()}: {self.path} was not written. Free some space and run again.", kind
            )
        if kind == "limit":
            return StorageError(f"The video {self.path} was not written: {TOO_LARGE_MESSAGE}.", kind)
        return StorageError(f"Cannot write the video {self.path}: {error_reason(error)}. Choose another folder.", kind)


class _Sink:
    """The file under its temporary name. It keeps the first failure, which libav reports late or never."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb")
        self.name = str(path)
        self.error: OSError | None = None
        self.discard = False

    def write(self, data: bytes) -> int:
        if not self.discard and self.error is None:
            try:
                self._file.write(data)
            except OSError as error:
                self.error = error
        return len(data)

    def seek(self, offset: int, whence: int = 0) -> int:
        if self.discard or self.error is not None:
            return 0
        try:
            return self._file.seek(offset, whence)
        except OSError as error:
            self.error = error
            return 0

    def tell(self) -> int:
        return self._file.tell()

    def finish(self) -> None:
        """Flush the file, or raise the first failure."""
        if self.error is not None:
            raise self.error
        self._file.close()

    def close(self) -> None:
        try:
            self._file.close()
        except OSError as error:  # raised by the flush of data for which the disk had no space
            self.error = self.error or error
