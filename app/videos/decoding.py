"""Decodes and encodes pictures of a video in a cage, a process with limits.

Each open video has one cage. A picture of a few hundred kilobytes passes a socket in less than a tenth of a
millisecond, and the server can answer other requests while it is decoded.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal, Protocol

import cv2
import numpy as np

from app.cages.cage import CageError, Cages
from app.cages.failures import raised, report
from app.cages.limits import Limits
from app.cages.talk import Ended, Talk
from app.errors import Busy, Invalid
from tsr_engine.errors import VideoError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource, display_path
from tsr_engine.io.video import Video, open_video
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.json_shapes import JsonObject
from tsr_engine.records import Picture

__all__ = ["PATIENCE", "CagedDecoder", "Decoder", "Encoding", "LocalDecoder", "Opener", "encode_picture", "open_here"]

Encoding = Literal["jpeg", "webp"]
PATIENCE = 60.0
"""Seconds that one picture may take; far more than any takes on a busy machine, however far from its key frame."""


class Decoder(Protocol):
    """An open video. Frames are ordinals."""

    width: int
    height: int
    frames: int
    path: Path

    @property
    def position(self) -> int:
        """Ordinal of the frame after which decoding continues without a seek."""

    def encoded(self, ordinal: int, width: int, encoding: Encoding) -> bytes:
        """Return a picture as a file."""

    def picture(self, ordinal: int) -> Picture:
        """Return a picture, BGR."""

    def close(self) -> None:
        """Release the file."""


class LocalDecoder:
    """A video that this process has opened."""

    def __init__(self, video: Video) -> None:
        self._video = video
        self.width, self.height, self.path = video.width, video.height, video.path
        self.frames = len(video.table)

    @property
    def position(self) -> int:
        """See ``Video.position``."""
        return self._video.position

    def encoded(self, ordinal: int, width: int, encoding: Encoding) -> bytes:
        """See ``encode_picture``."""
        return encode_picture(self.picture(ordinal), width, encoding)

    def picture(self, ordinal: int) -> Picture:
        """See ``Video.read``."""
        return self._video.read(ordinal).picture

    def close(self) -> None:
        """Close the video."""
        self._video.close()


class Opener(Protocol):
    """Opens videos in this process or another."""

    def __call__(self, source: VideoSource, limits: VideoLimits, table: FrameTable | None = None) -> Decoder:
        """Open a video.

        Args:
            source: its file.
            limits: limits of the video.
            table: its frame table; unset: it is made again.

        Raises:
            VideoError: the file cannot be opened.
            Busy: no process can be started.
        """


def open_here(source: VideoSource, limits: VideoLimits, table: FrameTable | None = None) -> Decoder:
    """Open a video in this process, for a worker, which has limits itself.

    Raises:
        VideoError: the file cannot be opened.
    """
    return LocalDecoder(open_video(source, limits=limits, table=table))


class CagedDecoder:
    """A video that is open in a cage.

    Raises:
        VideoError: the file cannot be opened.
        Busy: the server ends, or no process can be started.
    """

    def __init__(
        self,
        cages: Cages,
        source: VideoSource,
        limits: VideoLimits,
        table: FrameTable | None = None,
        *,
        memory_mb: int,
    ) -> None:
        self._cages = cages
        self.path = display_path(source)
        try:
            self.cage = cages.open("app.videos.decoding:decode_apart", source, limits, table, limits=Limits(memory_mb))
        except CageError as error:
            raise Busy(f"The video cannot be opened: {error}.", code="busy") from None
        self.cage.talk.set_timeout(PATIENCE)
        self._memory_mb = memory_mb
        self.position = 0
        try:
            opened, _ = self._received()
        except BaseException:
            self.close()
            raise
        self.width, self.height, self.frames = (int(opened[name]) for name in ("width", "height", "frames"))

    def encoded(self, ordinal: int, width: int, encoding: Encoding) -> bytes:
        """See ``encode_picture``; errors as for ``picture``."""
        return bytes(self._asked({"frame": ordinal, "width": width, "encoding": encoding})[1])

    def picture(self, ordinal: int) -> Picture:
        """Return a picture, BGR.

        Raises:
            VideoError: it cannot be decoded, or the cage has ended.
        """
        said, content = self._asked({"frame": ordinal})
        if len(content) != 3 * self.width * self.height or said.get("shape") != [self.height, self.width, 3]:
            raise VideoError("the picture has another size than the video")
        return np.frombuffer(content, np.uint8).reshape(self.height, self.width, 3)

    def close(self) -> None:
        """End the cage."""
        self._cages.end(self.cage)

    def _asked(self, question: JsonObject) -> tuple[JsonObject, bytearray]:
        try:
            self.cage.talk.send(question)
        except Ended:
            raise VideoError("the process that decodes the video has ended") from None
        said, content = self._received()
        self.position = int(said.get("position", 0))
        return said, content

    def _received(self) -> tuple[JsonObject, bytearray]:
        try:
            said, content = self.cage.talk.receive()
        except Ended:
            self.cage.kill()  # it may still be decoding
            raise VideoError("the process that decodes the video has ended, or took too long") from None
        if "failed" in said:
            raise raised(said["failed"], self._memory_mb)
        return said, content


def decode_apart(talk: Talk, source: VideoSource, limits: VideoLimits, table: FrameTable | None) -> None:
    """Run in the cage: open the file, which is checked again, and answer requests until the connection ends."""
    with open_video(source, limits=limits, table=table) as video:
        decoder = LocalDecoder(video)
        talk.send({"width": decoder.width, "height": decoder.height, "frames": decoder.frames})
        while True:
            question, _ = talk.receive()
            try:
                if "encoding" in question:
                    content = decoder.encoded(question["frame"], question["width"], question["encoding"])
                    talk.send({"position": video.position}, content)
                else:
                    picture = np.ascontiguousarray(decoder.picture(question["frame"]))
                    talk.send({"position": video.position, "shape": list(picture.shape)}, picture.data.cast("B"))
            except Ended:
                raise
            except Exception as error:
                talk.send({"failed": report(error)})


def encode_picture(picture: Picture, width: int, encoding: Encoding) -> bytes:
    """Encode a BGR picture as JPEG or WebP, shrunk to ``width`` px if it is wider.

    Raises:
        Invalid: the picture is too large for the format (WebP: 16,383 px).
    """
    if width < picture.shape[1]:
        height = max(1, round(picture.shape[0] * width / picture.shape[1]))
        picture = np.asarray(cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8)
    options = [cv2.IMWRITE_JPEG_QUALITY, 88] if encoding == "jpeg" else [cv2.IMWRITE_WEBP_QUALITY, 82]
    try:
        good, code = cv2.imencode(".jpg" if encoding == "jpeg" else ".webp", picture, options)
    except cv2.error:
        good = False
    if not good:
        raise Invalid(f"The picture cannot be written as {encoding}.", field="format")
    return code.tobytes()
