"""Parses other tools' picture names: the text before the frame number, the number, and the text after it.

A name must match as a whole, else it has no number: the last digits of a hash, a date or a size are not a frame.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

from tsr_engine.exchange.video_spellings import VIDEO_SUFFIXES, without_upload_prefix

EXPECTED_NAMES: Final = "frame_000010.jpg, NAME_000010.jpg or NAME_10.jpg, with the name of the video before the number"
"""Forms that a name may have, for messages."""

_PICTURE_SUFFIXES = "jpe?g|png|bmp|webp|tiff?|ppm|pgm|heic|avif"
_SUFFIX = re.compile(rf"\.(?:{_PICTURE_SUFFIXES}|txt|xml|json)\Z", re.IGNORECASE)
_TOOL_NAME = re.compile(r"frame_(\d{6,9})(?:\.(?:jpg|png|txt|xml))?", re.ASCII)
"""The form of most names; the general pattern gives the same result more slowly."""
_ROBOFLOW = re.compile(rf"(?P<name>.+?)(?:_(?:{_PICTURE_SUFFIXES}))?\.rf\.[0-9A-Za-z_-]{{6,64}}", re.IGNORECASE)
_ROBOFLOW_FRAME = re.compile(rf"(?:.*[._](?:{VIDEO_SUFFIXES})-\d+|.*-\d{{4,}})", re.IGNORECASE | re.ASCII)
_OF_VIDEO = re.compile(rf".*[._](?:{VIDEO_SUFFIXES})-\d+", re.IGNORECASE | re.ASCII)
_SECONDS = re.compile(r"(?P<name>.+)(?:#|%23)t=(?P<seconds>\d{1,7}(?:\.\d{1,12})?)", re.ASCII)
_MANGLED_SECONDS = re.compile(
    rf".*[._-](?:{VIDEO_SUFFIXES})[^0-9A-Za-z]*t[-_.=]\d+(?:[-_.]\d+)?", re.IGNORECASE | re.ASCII
)
_UUID = re.compile(r"(?:.*[^0-9a-f])?[0-9a-f]{8}-(?:[0-9a-f]{4}-){3}[0-9a-f]{12}", re.IGNORECASE)
_HASH = re.compile(r"(?:.*[^0-9a-z])?(?=\d*[a-f])[0-9a-f]{16,}", re.IGNORECASE | re.ASCII)
_DATE = r"(?<!\d)(?:19|20)\d\d[-_.]?(?:0[1-9]|1[0-2])[-_.]?(?:0[1-9]|[12]\d|3[01])(?!\d{1,2}(?!\d))"
_TIME = r"(?:[01]\d|2[0-3])[-_.h:]?[0-5]\d[-_.m:]?[0-5]\d(?:\.?\d{3}|\.?\d{6})?"
_TIMESTAMP = re.compile(
    rf"(?:.*?(?<![0-9A-Za-z]))?"
    rf"(?:{_DATE}(?:(?:[-_. T]|[-_ ]at[-_ ])?{_TIME})?|(?:[01]\d|2[0-3])(?:[-_.:][0-5]\d){{2}})",
    re.ASCII,
)
_NUMBER = re.compile(r"(?<!\d)\d{1,9}\Z", re.ASCII)
_SEPARATOR = re.compile(r"(?<=[^\W_])(?: - |__?|[-. ])\Z")
_WORD = re.compile(r"[^\W\d_]+\Z")
_DECIMAL = re.compile(r"(?:.*[^0-9A-Za-z])?\d+\.", re.ASCII)
_GENERIC = "frames?|img|images?|im|pic|pics|pictures?|photos?|f|fr|out|output|stills?|shot|snapshot"
_GENERIC_END = re.compile(rf"(?:(?P<core>.*[^\W_])[-_. ]+)?(?:{_GENERIC})", re.IGNORECASE)
_NUMBERED = re.compile(rf"(?:(?:{_GENERIC})[-_. ]*)?\d+", re.IGNORECASE | re.ASCII)


@dataclass(frozen=True, slots=True)
class PictureName:
    """The parts of a picture's name.

    Attributes:
        stem: text before the number, without words such as ``frame``; may be empty.
        pattern: unchanged text before the number; pictures of one sequence share it.
        number: the frame number, from 0 or from 1; None: there is none.
        seconds: the time, if the name has a time instead of a number.
        width: digits of the number, and whether the first of several digits is a zero.
        roboflow: whether Roboflow extracted the picture from a video.
        ambiguous: whether another number stands before it, so that one name alone does not identify the frame number.
        reason: reason for a missing number, as the end of a sentence.
    """

    stem: str = ""
    pattern: str = ""
    number: int | None = None
    seconds: float | None = None
    width: tuple[int, bool] = (0, False)
    roboflow: bool = False
    ambiguous: bool = False
    reason: str = "has no frame number"


def is_generic(name: str) -> bool:
    """Whether a name such as ``frame`` or ``img`` says nothing about a video."""
    found = _GENERIC_END.fullmatch(name)
    return found is not None and not found["core"]


def parse_picture_name(base: str, is_video_name: Callable[[str], bool]) -> PictureName:
    """Parse a name.

    Args:
        base: name of the picture or its label file, without folder.
        is_video_name: whether a text is a spelling of the video's name.
    """
    own_form = _TOOL_NAME.fullmatch(base)
    if own_form:
        return PictureName("", "frame_", int(own_form[1]), width=_digit_width(own_form[1]))
    base = _without_suffixes(base)
    of_roboflow = _ROBOFLOW.fullmatch(base)
    if of_roboflow:
        base = _without_suffixes(of_roboflow["name"])
    time = _SECONDS.fullmatch(base)
    if time:
        return PictureName(time["name"], time["name"], seconds=float(time["seconds"]))
    for pattern, reason in (
        (_MANGLED_SECONDS, "has a time whose decimal point another tool has replaced"),
        (_UUID, "has a UUID, no frame number"),
        (_HASH, "has a hash, no frame number"),
    ):
        if pattern.fullmatch(base):
            return PictureName(reason=reason)
    if is_video_name(base):
        return PictureName(reason="is the name of the video, without a frame number")
    if _TIMESTAMP.fullmatch(base):
        return PictureName(reason="has a date or a time of day, no frame number")
    found = _parse_number(without_upload_prefix(base), is_video_name)
    is_video_frame = found.number is not None and (_ROBOFLOW_FRAME if of_roboflow else _OF_VIDEO).fullmatch(base)
    return replace(found, roboflow=True) if is_video_frame else found


def _without_suffixes(name: str) -> str:
    """The name without suffixes of pictures and label files."""
    while True:
        bare = _SUFFIX.sub("", name)
        if bare == name or not bare:
            return name
        name = bare


def _digit_width(digits: str) -> tuple[int, bool]:
    return len(digits), digits[0] == "0" and len(digits) > 1


def _parse_number(base: str, is_video_name: Callable[[str], bool]) -> PictureName:
    found = _NUMBER.search(base)
    if found is None:
        return PictureName()
    head, digits = base[: found.start()], found[0]
    separator = _SEPARATOR.search(head)
    stem = head[: separator.start()] if separator else head
    if head and separator is None:
        word = _WORD.search(head)
        alone = word is not None and not word.start()
        if word is None or not (alone or is_generic(word[0]) or is_video_name(head)):
            return PictureName()
        if word.start() and not _SEPARATOR.search(head[: word.start()]) and not is_video_name(head):
            return PictureName()
    if _DECIMAL.fullmatch(head):
        return PictureName(reason="has a number with decimals, no frame number")
    generic = None if is_video_name(stem) else _GENERIC_END.fullmatch(stem)
    if generic:
        stem = generic["core"] or ""
    is_ambiguous = bool(_NUMBERED.fullmatch(stem) or _TIMESTAMP.fullmatch(stem)) and not is_video_name(stem)
    return PictureName(stem, head, int(digits), width=_digit_width(digits), ambiguous=is_ambiguous)
