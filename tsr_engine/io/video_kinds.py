"""The kinds of video files, recognised by their first bytes.

The kind decides the demuxer, so that no demuxer opens other files for a file: a text playlist named ``x.mp4`` is
refused here.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Literal

Address = Literal["time", "position", "count"]


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of file.

    Attributes:
        name: the name that people see.
        demuxer: FFmpeg's name of the demuxer.
        address: how a picture is identified after a seek. ``time``: by its presentation time. ``position``: by
            the byte position of its packet. ``count``: by the number of its packet, because some packets have neither
            time nor position.
        states_length: whether the header states the video's length, so that one that ends earlier is cut short.
        layered: whether each picture is merged into the one before, so that decoding can start only at the first.
    """

    name: str
    demuxer: str
    address: Address = "time"
    states_length: bool = True
    layered: bool = False


_MP4 = Kind("MP4", "mov")
# AVI stores no presentation times, so its demuxer guesses them. Without an index, it restarts decoding times after
# each seek.
_AVI = Kind("AVI", "avi", "position")
_MATROSKA = Kind("Matroska", "matroska")
_TS = Kind("MPEG-TS", "mpegts", "count", states_length=False)
_PS = Kind("MPEG-PS", "mpeg", "count", states_length=False)
_H264 = Kind("H.264", "h264", "count", states_length=False)
_HEVC = Kind("HEVC", "hevc", "count", states_length=False)
_FLV = Kind("FLV", "flv")
_ASF = Kind("WMV", "asf")
_GIF = Kind("GIF", "gif", states_length=False, layered=True)
_APNG = Kind("APNG", "apng", states_length=False, layered=True)
_WEBP = Kind("WebP", "webp", states_length=False, layered=True)

DEMUXERS: Final = "mov,mp4,m4a,3gp,3g2,mj2,avi,matroska,webm,mpegts,mpeg,h264,hevc,flv,asf,gif,apng"
"""Demuxers that FFmpeg may use; none of them opens another file."""
KIND_NAMES: Final = (
    "MP4, MOV, AVI, MKV, WebM, MPEG-TS, MTS, MPEG-PS, FLV, WMV, raw H.264 or HEVC, animated GIF, PNG or WebP"
)
VIDEO_SUFFIXES: Final = (
    *(".mp4", ".mov", ".m4v", ".3gp", ".mkv", ".webm", ".avi", ".ts", ".m2ts", ".mts", ".m2t", ".mpg", ".mpeg", ".vob"),
    *(".flv", ".wmv", ".asf", ".h264", ".264", ".avc", ".h265", ".265", ".hevc", ".gif", ".apng"),
)
"""Suffixes of such files."""
PICTURE_SUFFIXES: Final = (".png", ".webp")
"""Suffixes of files that are mostly single pictures and may be animated."""
HEAD_BYTES: Final = 2**18
"""Number of leading bytes that identify the kind of any file."""
MIN_HEAD_BYTES: Final = 4096
"""Number of leading bytes that identify most kinds; a raw stream may need ``HEAD_BYTES``."""

_ISO_BOXES = (b"ftyp", b"moov", b"mdat", b"free", b"skip", b"wide", b"pnot", b"styp", b"uuid")
ASF_HEADER = bytes.fromhex("3026b2758e66cf11a6d900aa0062ce6c")
_PNG = b"\x89PNG\r\n\x1a\n"
_TS_PACKETS = (188, 192, 204)
"""Bytes between two sync bytes: plain, with a preceding time code (MTS), and with trailing check bytes."""
_MIN_TS_PACKETS, _MAX_TS_PACKETS = 5, 24
"""Number of packets of a transport stream that are checked."""
_MIN_UNITS = 3
"""Number of valid units that a raw stream without parameters needs: it was cut out of a longer one."""


def kind_of(head: bytes) -> Kind | None:
    """The kind of a file that begins with these bytes; None: it is not read as a video.

    Args:
        head: the first ``HEAD_BYTES`` bytes, or all of a shorter file.
    """
    if head[4:8] in _ISO_BOXES:
        return _MP4
    if head[:4] == b"RIFF" and head[8:11] == b"AVI":
        return _AVI
    if head[:4] == b"RIFF" and head[8:16] == b"WEBPVP8X" and len(head) > 20 and head[20] & 2:
        return _WEBP
    if head.startswith(b"\x1aE\xdf\xa3"):
        return _MATROSKA
    if head.startswith(b"FLV\x01"):
        return _FLV
    if head.startswith(ASF_HEADER):
        return _ASF
    if head.startswith((b"GIF87a", b"GIF89a")):
        return _GIF
    if head.startswith(_PNG) and _has_animation(head):
        return _APNG
    if head.startswith(b"\0\0\1\xba") and len(head) > 4 and (head[4] >> 6 == 1 or head[4] >> 4 == 2):
        return _PS
    if _is_transport_stream(head):
        return _TS
    return _raw_kind(head)


def cannot_be_video(start: bytes) -> bool:
    """Whether a file can be refused by its first ``MIN_HEAD_BYTES`` bytes; raw streams may need ``HEAD_BYTES``."""
    return kind_of(start) is None and not start.startswith(b"\0\0")


def not_a_video_message(name: object, head: bytes) -> str:
    """The error sentence for a file of no known kind.

    Args:
        name: the file's name.
        head: its first bytes.
    """
    still = _still_picture_kind(head)
    if still is not None:
        return f"{name} is not a video but a single picture ({still}). Use `tsr detect` for pictures."
    return f"{name} is not a video: its first bytes match none of {KIND_NAMES}. Convert it to MP4 first."


def _still_picture_kind(head: bytes) -> str | None:
    """The kind of a file with one picture; None: not known."""
    if head.startswith(_PNG):
        return "PNG"
    if head.startswith(b"\xff\xd8\xff"):
        return "JPEG"
    return "WebP" if head[:4] == b"RIFF" and head[8:12] == b"WEBP" else None


def _has_animation(png: bytes) -> bool:
    """Whether a PNG has an ``acTL`` chunk, which must precede the pixels."""
    at = len(_PNG)
    while at + 8 <= len(png):
        size, name = struct.unpack_from(">I4s", png, at)
        if name in (b"acTL", b"IDAT"):
            return bool(name == b"acTL")
        at += 12 + size
    return False


def _is_transport_stream(head: bytes) -> bool:
    """Whether sync bytes precede possible headers at equal distances; the first packet may be cut."""
    for step in _TS_PACKETS:
        for first in range(min(step, len(head))):
            positions = range(first, len(head) - 3, step)[:_MAX_TS_PACKETS]
            if len(positions) >= _MIN_TS_PACKETS and all(_is_packet(head, at) for at in positions):
                return True
    return False


def _is_packet(head: bytes, at: int) -> bool:
    # sync byte, and an adaptation field, a payload or both after the header
    return head[at] == 0x47 and head[at + 3] & 0x30 != 0


def _raw_kind(head: bytes) -> Kind | None:
    """H.264 or HEVC by the unit headers after the start codes: all of them must be possible."""
    if not head.startswith((b"\0\0\1", b"\0\0\0\1")):
        return None
    units = list(_units(head))
    for kind, unit_type, parameters in ((_H264, _is_h264, _H264_PARAMETERS), (_HEVC, _is_hevc, _HEVC_PARAMETERS)):
        found = [unit_type(a, b) for a, b in units]
        if all(number is not None for number in found) and (parameters & set(found) or len(found) >= _MIN_UNITS):
            return kind
    return None


def _units(head: bytes) -> Iterator[tuple[int, int]]:
    """Yield the first two bytes after each start code."""
    at = head.find(b"\0\0\1")
    while 0 <= at < len(head) - 4:
        yield head[at + 3], head[at + 4]
        at = head.find(b"\0\0\1", at + 3)


_H264_PARAMETERS, _HEVC_PARAMETERS = {7}, {32, 33}


def _is_h264(first: int, _: int) -> int | None:
    """The type of a unit (H.264, 7.3.1 and table 7-1); None: it is impossible."""
    importance, number = first >> 5, first & 31
    if importance > 3 or not 1 <= number <= 20 or number in (16, 17, 18):
        return None
    # start pictures and parameters may be references; marks and messages are not
    wrong = importance == 0 if number in (5, 7, 8) else importance > 0 and number in (6, 9, 10, 11, 12)
    return None if wrong else number


def _is_hevc(first: int, second: int) -> int | None:
    """The type of a unit (HEVC, 7.3.1.2 and table 7-1); None: it is impossible."""
    number, layer, temporal = first >> 1, (first & 1) << 5 | second >> 3, second & 7
    possible = number <= 9 or 16 <= number <= 21 or 32 <= number <= 40
    return number if possible and layer < 63 and temporal > 0 else None
