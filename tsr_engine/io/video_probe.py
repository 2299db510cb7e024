"""Checks video files and refuses bad ones with the reason, before memory for a picture is allocated."""

from __future__ import annotations

import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import av
from av.container import InputContainer

from tsr_engine.errors import VideoError
from tsr_engine.io.opened_file import OpenedFile, VideoSource, open_source, unreadable_message
from tsr_engine.io.video_kinds import DEMUXERS, HEAD_BYTES, KIND_NAMES, Kind, kind_of, not_a_video_message
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.io.video_webp import WebpFile


def video_sha256(source: VideoSource | str) -> str:
    """The identity of a video: SHA-256 of the file's bytes, hex; the file is read piece by piece.

    Raises:
        VideoError: the file is missing or cannot be read, or the source refuses it.
    """
    with open_source(source) as file:
        if not stat.S_ISREG(file.status.st_mode):
            raise VideoError(unreadable_message(file.path, IsADirectoryError(0, "it is not a regular file")))
        return file.sha256()


def check_file(file: Path | OpenedFile) -> Kind:
    """Refuse a file that is not a video by its first bytes, before a demuxer reads it.

    Demuxers choose by content: they would follow a text playlist named ``x.mp4`` to other files.

    Returns:
        The kind of the video file.

    Raises:
        VideoError: missing, not a regular file, unreadable, empty, or of no known video container.
    """
    if isinstance(file, Path):
        with OpenedFile.by_name(file) as opened:
            return check_file(opened)
    path, mode = file.path, file.status.st_mode
    if stat.S_ISDIR(mode):
        raise VideoError(f"Expected a video file, but {path} is a folder. Name one file ({KIND_NAMES}).")
    if not stat.S_ISREG(mode):
        raise VideoError(f"Expected a video file, but {path} is not a regular file. Name one file ({KIND_NAMES}).")
    try:
        with file.stream() as stream:
            head = stream.read(HEAD_BYTES)
    except OSError as error:
        raise VideoError(unreadable_message(path, error)) from None
    if not head:
        raise VideoError(f"{path} is empty (0 bytes). Copy the video again from its source.")
    kind = kind_of(head)
    if kind is None:
        raise VideoError(not_a_video_message(path, head))
    return kind


@contextmanager
def open_container(file: OpenedFile, limits: VideoLimits) -> Iterator[tuple[InputContainer, av.VideoStream, Kind]]:
    """Check an open file, open it for demuxing at a separate position, and find its video stream.

    The demuxer is that of the file's kind and restricted to local files. The pixel limit also applies to the decoders
    that the demuxer runs to find stream parameters: a huge picture is refused before it is allocated.

    Yields:
        The PyAV container, its video stream and the kind of file. Decoding uses one thread, because concealment of
        damaged pictures would otherwise depend on thread timing.

    Raises:
        VideoError: not a readable video, no video stream, no decoder, or a picture over the limits.
    """
    path = file.path
    kind = check_file(file)
    options = {"protocol_whitelist": "file", "format_whitelist": DEMUXERS, "max_pixels": _decoder_limit(limits)}
    try:
        container: InputContainer
        if kind.demuxer == "webp":
            container = WebpFile(  # type: ignore[assignment]  # it has what is used of a container
                file.stream, lambda width, height: check_size(path, width, height, limits)
            )
        else:
            container = av.open(
                f"file:{file.reopen_path}", mode="r", format=kind.demuxer, options=options, metadata_errors="replace"
            )
    except (av.FFmpegError, OSError, ValueError, MemoryError) as error:
        raise VideoError(
            f"{path} cannot be opened as a video ({error_reason(error)}): it is damaged or cut short, or not "
            f"{kind.name} though it begins like that. Copy it again from its source or repair it."
        ) from None
    with container:
        stream = _video_stream(container, path)
        context = stream.codec_context
        width, height = int(context.width), int(context.height)
        # A decoder that refuses a size leaves no size.
        if not width or not height:
            raise VideoError(
                f"{path} has pictures of no readable size, or of more than the limit of {limits.max_pixels} pixels. "
                "Copy it again from its source, or scale it down."
            )
        check_size(path, width, height, limits)
        context.options = {"max_pixels": _decoder_limit(limits)}
        context.thread_type = "NONE"
        context.thread_count = 1
        yield container, stream, kind


def check_size(path: Path, width: int, height: int, limits: VideoLimits) -> None:
    """Refuse pictures over the limits.

    Raises:
        VideoError: a picture has too many pixels, or a side is too long.
    """
    if width * height > limits.max_pixels or max(width, height) > limits.max_side:
        raise VideoError(
            f"{path} has pictures of {width}x{height}, more than the limit of {limits.max_pixels} pixels or "
            f"{limits.max_side} px a side. Scale it down first."
        )


def _decoder_limit(limits: VideoLimits) -> str:
    """The decoders' pixel limit, which includes the padding of their buffers."""
    return str(2 * limits.max_pixels + 2**16)


def video_streams(container: InputContainer) -> list[av.VideoStream]:
    """The video streams of an open file; the first is the one that is read.

    It is the first stream that can be decoded. Cover art, a stream of one attached picture, does not count.
    """
    streams = [s for s in container.streams.video if not s.disposition & s.disposition.__class__.attached_pic]
    return sorted(streams, key=lambda stream: stream.codec_context is None)


def _video_stream(container: InputContainer, path: Path) -> av.VideoStream:
    streams = video_streams(container)
    if not streams:
        kind = "only sound" if container.streams.audio else "no streams that can be read"
        raise VideoError(f"{path} has no pictures: it holds {kind}. Choose a file with a video stream.")
    if streams[0].codec_context is None:
        raise VideoError(
            f"{path} has pictures that cannot be decoded: the file is cut short, or coded in a way that this "
            "installation does not know. Copy it again from its source or convert it to H.264."
        )
    return streams[0]


def error_reason(error: BaseException) -> str:
    """The short cause of a decoder's exception, without file names."""
    text = getattr(error, "strerror", None) or type(error).__name__
    return str(text).rstrip(".")
