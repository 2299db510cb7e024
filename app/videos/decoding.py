"""Decodes and encodes pictures of a video in a sandbox, a process with limits.

Each open video has one sandbox. A picture of a few hundred kilobytes passes a socket in less than a tenth of a
millisecond, and the server can answer other requests while it is decoded.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal, Protocol

import cv2
import numpy as np

from app.errors import Busy, Invalid
from app.sandbox.channel import Channel, ChannelClosed
from app.sandbox.failures import decode_failure, encode_failure
from app.sandbox.limits import Limits
from app.sandbox.sandboxes import SandboxError, Sandboxes
from tsr_engine.errors import VideoError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource, display_path
from tsr_engine.io.video import Video, open_video
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.json_shapes import JsonObject
from tsr_engine.records import Picture

Encoding = Literal["jpeg", "webp"]
PICTURE_TIMEOUT_S = 60.0
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


def open_in_process(source: VideoSource, limits: VideoLimits, table: FrameTable | None = None) -> Decoder:
    """Open a video in this process, for a worker, which has limits itself.

    Raises:
        VideoError: the file cannot be opened.
    """
    return LocalDecoder(open_video(source, limits=limits, table=table))


class SandboxedDecoder:
    """A video that is open in a sandbox.

    Raises:
        VideoError: the file cannot be opened.
        Busy: the server ends, or no process can be started.
    """

    def __init__(
        self,
        sandboxes: Sandboxes,
        source: VideoSource,
        limits: VideoLimits,
        table: FrameTable | None = None,
        *,
        memory_mb: int,
    ) -> None:
        self._sandboxes = sandboxes
        self.path = display_path(source)
        try:
            self.sandbox = sandboxes.open(
                "app.videos.decoding:decode_in_sandbox", source, limits, table, limits=Limits(memory_mb)
            )
        except SandboxError as error:
            raise Busy(f"The video cannot be opened: {error}.", code="busy") from None
        self.sandbox.channel.set_timeout(PICTURE_TIMEOUT_S)
        self._memory_mb = memory_mb
        self.position = 0
        try:
            opened, _ = self._receive()
        except BaseException:
            self.close()
            raise
        self.width, self.height, self.frames = (int(opened[name]) for name in ("width", "height", "frames"))

    def encoded(self, ordinal: int, width: int, encoding: Encoding) -> bytes:
        """See ``encode_picture``; errors as for ``picture``."""
        return bytes(self._request({"frame": ordinal, "width": width, "encoding": encoding})[1])

    def picture(self, ordinal: int) -> Picture:
        """Return a picture, BGR.

        Raises:
            VideoError: it cannot be decoded, or the sandbox has ended.
        """
        message, content = self._request({"frame": ordinal})
        if len(content) != 3 * self.width * self.height or message.get("shape") != [self.height, self.width, 3]:
            raise VideoError("the picture has another size than the video")
        return np.frombuffer(content, np.uint8).reshape(self.height, self.width, 3)

    def close(self) -> None:
        """End the sandbox."""
        self._sandboxes.end(self.sandbox)

    def _request(self, request: JsonObject) -> tuple[JsonObject, bytearray]:
        try:
            self.sandbox.channel.send(request)
        except ChannelClosed:
            raise VideoError("the process that decodes the video has ended") from None
        message, content = self._receive()
        self.position = int(message.get("position", 0))
        return message, content

    def _receive(self) -> tuple[JsonObject, bytearray]:
        try:
            message, content = self.sandbox.channel.receive()
        except ChannelClosed:
            self.sandbox.kill()  # it may still be decoding
            raise VideoError("the process that decodes the video has ended, or took too long") from None
        if "failed" in message:
            raise decode_failure(message["failed"], self._memory_mb)
        return message, content


def decode_in_sandbox(channel: Channel, source: VideoSource, limits: VideoLimits, table: FrameTable | None) -> None:
    """Run in the sandbox: open the file, which is checked again, and answer requests until the connection ends."""
    with open_video(source, limits=limits, table=table) as video:
        decoder = LocalDecoder(video)
        channel.send({"width": decoder.width, "height": decoder.height, "frames": decoder.frames})
        while True:
            request, _ = channel.receive()
            try:
                if "encoding" in request:
                    content = decoder.encoded(request["frame"], request["width"], request["encoding"])
                    channel.send({"position": video.position}, content)
                else:
                    picture = np.ascontiguousarray(decoder.picture(request["frame"]))
                    channel.send({"position": video.position, "shape": list(picture.shape)}, picture.data.cast("B"))
            except ChannelClosed:
                raise
            except Exception as error:
                channel.send({"failed": encode_failure(error)})


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
        is_encoded, data = cv2.imencode(".jpg" if encoding == "jpeg" else ".webp", picture, options)
    except cv2.error:
        is_encoded = False
    if not is_encoded:
        raise Invalid(f"The picture cannot be written as {encoding}.", field="format")
    return data.tobytes()
