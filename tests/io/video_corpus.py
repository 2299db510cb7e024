"""Makes small videos of every unusual kind. Each picture shows its number as a bar code, so that a test can read
from the pixels which frame it is.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache, partial
from pathlib import Path
from typing import Any

import av
import numpy as np

WIDTH, HEIGHT = 96, 64
_BITS, _ROWS, _MARK = 6, 2, 16


def draw_code(number: int, width: int = WIDTH, height: int = HEIGHT) -> np.ndarray:
    """A picture with 12 bits as blocks in the upper left corner; the rest moves with the number."""
    y, x = np.mgrid[:height, :width]
    picture = np.stack([(x * 2 + number * 7) % 200, (y * 3 + number * 5) % 200, (x + y + number * 3) % 200], axis=-1)
    picture = picture.astype(np.uint8)
    for bit in range(_BITS * _ROWS):
        row, column = divmod(bit, _BITS)
        value = 235 if number >> bit & 1 else 20
        picture[row * _MARK : (row + 1) * _MARK, column * _MARK : (column + 1) * _MARK] = value
    return picture


def read_code(picture: np.ndarray) -> int:
    """The number in a picture's bar code; fails if a block is neither dark nor bright."""
    number = 0
    for bit in range(_BITS * _ROWS):
        row, column = divmod(bit, _BITS)
        y, x = row * _MARK + 4, column * _MARK + 4
        value = float(picture[y : y + _MARK - 8, x : x + _MARK - 8].mean())
        assert value < 90 or value > 165, f"block {bit} reads {value:.0f}: no bar code"
        number |= int(value > 128) << bit
    return number


@dataclass(frozen=True)
class CorpusVideo:
    """A file and its ground truth."""

    path: Path
    codes: list[int]
    times: list[Fraction]
    rotation: int = 0
    size: tuple[int, int] = (WIDTH, HEIGHT)


@dataclass(frozen=True)
class Recipe:
    """Settings for one kind of file."""

    suffix: str = ".mp4"
    codec: str = "libx264"
    options: dict[str, str] = field(default_factory=dict)
    container: dict[str, str] = field(default_factory=dict)
    pix_fmt: str = "yuv420p"
    size: tuple[int, int] = (WIDTH, HEIGHT)
    count: int = 50
    ticks: Callable[[int], int] = lambda k: k
    time_base: Fraction = Fraction(1, 25)
    turn: tuple[int, bool] = (0, False)
    orient: Callable[[np.ndarray], np.ndarray] = lambda picture: picture
    rotation: int = 0
    delay: Fraction = Fraction(0)
    format: str | None = None
    shape: Fraction = Fraction(1)


def x264(**more: str) -> dict[str, str]:
    return {"preset": "ultrafast", "crf": "18", "threads": "1", "g": "12", "bf": "0", "sc_threshold": "0", **more}


def x265(more: str = "") -> dict[str, str]:
    return {"preset": "ultrafast", "x265-params": f"log-level=none:keyint=12:bframes=3{more}:pools=none"}


def rotated(degrees: int, shape: Fraction = Fraction(1)) -> Recipe:
    """Pictures on their side, which a player turns upright."""
    orient = partial(np.rot90, k=degrees // 90)
    turn = -90 if degrees == 90 else 90, False
    return Recipe(options=x264(), turn=turn, orient=orient, rotation=degrees, size=(HEIGHT, WIDTH), shape=shape)


def _irregular(k: int) -> int:
    return k * 40 + (k * k * 13) % 37  # milliseconds, monotonic


def _some_twice(k: int) -> int:
    return 40 * (k - (k >= 10 and k % 7 == 3))  # milliseconds: frames 10, 17, 24, ... are shown with the one before


_X264 = x264(bf="2")
_MPEG = {"bf": "2", "g": "12", "qscale": "2"}
_MS, _DELAY = Fraction(1, 1000), Fraction(2, 25)
RECIPES: dict[str, Recipe] = {
    "constant": Recipe(options=x264()),
    "ntsc": Recipe(options=_X264, time_base=Fraction(1001, 30000)),
    "variable": Recipe(options=_X264, ticks=_irregular, time_base=_MS),
    "b_frames": Recipe(options=x264(preset="veryfast", bf="3", **{"b-pyramid": "normal"})),
    "long_gop": Recipe(options=x264(bf="2", g="250")),
    "open_gop": Recipe(options=x264(preset="veryfast", bf="3", **{"x264-params": "open-gop=1:b-adapt=0"})),
    "offset_start": Recipe(options=_X264, ticks=lambda k: k + 133),
    "fragmented": Recipe(options=_X264, container={"movflags": "frag_keyframe+empty_moov"}, delay=_DELAY),
    "index_first": Recipe(options=_X264, container={"movflags": "faststart"}),
    "odd_size": Recipe(options=_X264, pix_fmt="yuv444p", size=(99, 67)),
    "odd_size_vp9": Recipe(
        ".webm", "libvpx-vp9", {"cpu-used": "8", "deadline": "realtime", "g": "12"}, size=(101, 67), count=20
    ),
    "matroska_variable": Recipe(".mkv", options=_X264, ticks=_irregular, time_base=_MS),
    # a millisecond clock is too coarse: every second frame repeats the previous stamp
    "repeated_stamps": Recipe(".mkv", options=x264(g="1"), ticks=lambda k: k // 2 * 40, time_base=_MS),
    "repeated_stamps_ffv1": Recipe(".mkv", "ffv1", {"g": "1"}, pix_fmt="bgr0", ticks=_some_twice, time_base=_MS),
    "repeated_stamps_gop": Recipe(".mkv", options=_X264, ticks=_some_twice, time_base=_MS),
    "fast": Recipe(".mkv", "ffv1", {"g": "1"}, pix_fmt="bgr0", ticks=lambda k: k // 2, time_base=_MS, count=100),
    "avi_h264": Recipe(".avi", options=_X264),
    "avi_mpeg4": Recipe(".avi", "mpeg4", _MPEG),
    "avi_mjpeg": Recipe(".avi", "mjpeg", {"qscale": "2"}, pix_fmt="yuvj420p", count=12),
    "mov_mjpeg": Recipe(".mov", "mjpeg", {"qscale": "2"}, pix_fmt="yuvj420p", count=12),
    "hevc": Recipe(codec="libx265", options=x265(":open-gop=1"), count=40),
    "ts": Recipe(".ts", options=_X264, delay=_DELAY),
    "ts_open_gop": Recipe(
        ".ts", options=x264(preset="veryfast", bf="3", **{"x264-params": "open-gop=1:b-adapt=0"}), delay=_DELAY
    ),
    "ts_mpeg2_interlaced": Recipe(
        ".ts", "mpeg2video", {"bf": "2", "g": "12", "qscale": "2", "flags": "+ildct+ilme"}, delay=Fraction(1, 25)
    ),
    "ts_odd_size": Recipe(".ts", options=_X264, pix_fmt="yuv444p", size=(99, 67), delay=_DELAY),
    "m2ts": Recipe(".mts", options=_X264, container={"mpegts_m2ts_mode": "1"}, format="mpegts", delay=_DELAY),
    "ps": Recipe(".mpg", "mpeg2video", _MPEG, delay=Fraction(27, 50)),
    "raw_h264": Recipe(".h264", options=_X264),
    "raw_hevc": Recipe(".hevc", "libx265", x265(), count=40),
    "flv": Recipe(".flv", options=_X264, delay=_DELAY),
    "wmv": Recipe(".wmv", "wmv2", {"g": "12", "qscale": "2"}),
    "gif": Recipe(".gif", "gif", pix_fmt="rgb8"),
    "apng": Recipe(".png", "apng", pix_fmt="rgb24", format="apng"),
    "webp": Recipe(".webp", "libwebp_anim", pix_fmt="yuv420p"),
    "untimed_start": Recipe(
        ".mkv",
        options=_X264,
        container={"avoid_negative_ts": "disabled", "cluster_time_limit": "480"},
        ticks=lambda k: 40 * k - 1200,
        time_base=_MS,
    ),
    # the 33-bit clock of MPEG wraps at the twentieth picture
    "ts_wrap": Recipe(
        ".ts",
        options=_X264,
        ticks=lambda k: 2**33 - 2**33 % 3600 + (k - 20) * 3600,
        time_base=Fraction(1, 90_000),
        delay=Fraction(-(2**33), 90_000),
    ),
    # the muxer fills the gap in time with empty chunks
    "avi_repeats": Recipe(
        ".avi", "mjpeg", {"qscale": "2"}, pix_fmt="yuvj420p", count=12, ticks=lambda k: k + 8 * (k >= 5)
    ),
    "wide_pixels": Recipe(options=_X264, shape=Fraction(4, 3)),
    "wide_pixels_ps": Recipe(".mpg", "mpeg2video", _MPEG, shape=Fraction(8, 9), delay=Fraction(27, 50)),
    "wide_pixels_rotated": rotated(90, shape=Fraction(4, 3)),
    "single": Recipe(options=x264(), count=1),
    "rotated_90": rotated(90),
    "rotated_180": Recipe(options=_X264, turn=(180, False), orient=lambda p: np.rot90(p, 2), rotation=180),
    "rotated_270": rotated(270),
    "mirrored": Recipe(options=x264(), turn=(0, True), orient=lambda p: p[:, ::-1]),
}


def make(recipe: Recipe, folder: Path, name: str) -> CorpusVideo:
    """Write one file; codes are 0, 1, 2, ... in presentation order."""
    path = folder / f"{name}{recipe.suffix}"
    stored = recipe.size
    upright = stored[::-1] if recipe.rotation in (90, 270) else stored
    with av.open(str(path), "w", format=recipe.format, options=recipe.container) as container:
        stream: Any = container.add_stream(recipe.codec, rate=25, options=recipe.options)
        stream.width, stream.height = stored
        stream.pix_fmt = recipe.pix_fmt
        stream.codec_context.sample_aspect_ratio = recipe.shape
        stream.codec_context.time_base = recipe.time_base
        if recipe.turn != (0, False):
            stream.set_display_rotation(recipe.turn[0], hflip=recipe.turn[1])
        for k in range(recipe.count):
            picture = np.ascontiguousarray(recipe.orient(draw_code(k, *upright)))
            frame = av.VideoFrame.from_ndarray(picture, format="bgr24")
            frame.pts, frame.time_base = recipe.ticks(k), recipe.time_base
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    times = [recipe.delay + recipe.ticks(k) * recipe.time_base for k in range(recipe.count)]
    return CorpusVideo(path, list(range(recipe.count)), times, recipe.rotation, upright)


def with_edit_list(video: CorpusVideo, path: Path, skip: int, keep: int) -> CorpusVideo:
    """A copy whose edit list shows ``keep`` frames from frame ``skip`` on; the file keeps all its packets."""
    content = bytearray(video.path.read_bytes())
    timescale = _timescale(content, b"mdhd")
    movie_scale = _timescale(content, b"mvhd")
    at = content.index(b"elst") + 4
    _, entries, _, media_time, _ = struct.unpack_from(">IIIiI", content, at)
    assert entries == 1
    step = timescale // 25
    struct.pack_into(">Ii", content, at + 8, round(Fraction(keep * movie_scale, 25)), media_time + skip * step)
    path.write_bytes(content)
    return CorpusVideo(path, video.codes[skip : skip + keep], video.times[:keep])


EDIT_LISTS: dict[str, tuple[str, int, int]] = {
    "edit_list": ("b_frames", 12, 30),
    "edit_list_inside_gop": ("b_frames", 17, 22),
    "edit_list_open_gop": ("open_gop", 14, 28),
    "edit_list_tail": ("constant", 0, 31),
}
"""Name -> what is cut, frames that are skipped, frames that are kept."""


def maker(folder: Path) -> Callable[[str], CorpusVideo]:
    """Return a function from a name of ``RECIPES`` or ``EDIT_LISTS`` to its file in a folder, made on first use."""

    @cache
    def get(name: str) -> CorpusVideo:
        if name not in EDIT_LISTS:
            return make(RECIPES[name], folder, name)
        source, skip, keep = EDIT_LISTS[name]
        return with_edit_list(get(source), folder / f"{name}.mp4", skip, keep)

    return get


def _timescale(content: bytes | bytearray, box: bytes) -> int:
    at = content.index(box) + 4
    assert content[at] == 0, "a version 0 box was expected"
    return int(struct.unpack_from(">I", content, at + 12)[0])


def joined(path: Path, *parts: CorpusVideo) -> CorpusVideo:
    """Join files as ``cat`` does; codes and times are those of a reader that continues."""
    path.write_bytes(b"".join(part.path.read_bytes() for part in parts))
    codes = [code for part in parts for code in part.codes]
    return CorpusVideo(
        path, codes, [parts[0].times[0] + Fraction(k, 25) for k in range(len(codes))], size=parts[0].size
    )


def without_start(video: CorpusVideo, path: Path, packet: int, unit: int = 1) -> Path:
    """A copy that begins with the given packet of the video, or up to ``unit`` bytes before."""
    with av.open(str(video.path)) as container:
        places = [packet.pos for packet in container.demux(video=0) if packet.size]
    path.write_bytes(video.path.read_bytes()[places[packet] // unit * unit :])
    return path


def make_two_streams(path: Path, count: int = 10) -> Path:
    """A file with two video streams; the codes of the second one are 100 higher."""
    with av.open(str(path), "w") as container:
        streams: list[Any] = [container.add_stream("libx264", rate=25, options=x264()) for _ in range(2)]
        for number, stream in enumerate(streams):
            stream.width, stream.height, stream.pix_fmt = WIDTH + 32 * number, HEIGHT, "yuv420p"
        for k in range(count + 1):
            for number, stream in enumerate(streams):
                frame = None
                if k < count:
                    picture = draw_code(k + 100 * number, WIDTH + 32 * number, HEIGHT)
                    frame = av.VideoFrame.from_ndarray(picture, format="bgr24")
                    frame.pts, frame.time_base = k, Fraction(1, 25)
                container.mux(stream.encode(frame))
    return path


def cut(video: CorpusVideo, path: Path, share: float) -> Path:
    """A copy of the first part of a file."""
    content = video.path.read_bytes()
    path.write_bytes(content[: int(len(content) * share)])
    return path


def flip_bits(video: CorpusVideo, path: Path, positions: Sequence[float]) -> Path:
    """A copy with single bits flipped in the coded pictures, at the given shares of the ``mdat`` box."""
    content = bytearray(video.path.read_bytes())
    start = content.index(b"mdat") + 4
    size = struct.unpack_from(">I", content, start - 8)[0] - 8
    for share in positions:
        content[start + int(share * (size - 1))] ^= 0x10
    path.write_bytes(content)
    return path


def make_sound(path: Path) -> Path:
    """A file with a sound track only."""
    with av.open(str(path), "w") as container:
        stream: Any = container.add_stream("aac", rate=44100)
        stream.layout = "mono"
        for k in range(10):
            frame = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), format="fltp", layout="mono")
            frame.sample_rate, frame.pts = 44100, k * 1024
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def make_empty(path: Path) -> Path:
    """A valid file with a video stream without frames."""
    with av.open(str(path), "w", options={"movflags": "empty_moov+frag_keyframe"}) as container:
        stream: Any = container.add_stream("mjpeg", rate=25)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuvj420p"
        container.start_encoding()
    return path


def make_huge(video: CorpusVideo, path: Path, side: int = 16_000, *, admit: bool = True) -> Path:
    """A small MJPEG MOV with pictures that claim ``side`` x ``side`` pixels; unless it admits that, its header lies."""
    content = bytearray(video.path.read_bytes())
    at = 0
    while (at := content.find(b"\xff\xc0\x00\x11\x08", at)) >= 0:
        struct.pack_into(">HH", content, at + 5, side, side)
        at += 9
    if admit:
        struct.pack_into(">HH", content, content.index(b"jpeg", content.index(b"stsd")) + 28, side, side)
    path.write_bytes(content)
    return path
