"""Recognises a video's name in other spellings: tools change case, spaces, punctuation and the suffix."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache
from pathlib import Path
from typing import Final
from urllib.parse import unquote

from tsr_engine.exchange.dataset import DatasetVideo
from tsr_engine.exchange.video_names import is_name_of

VIDEO_SUFFIXES: Final = "mp4|mov|m4v|mkv|webm|avi|3gp|mpe?g|mts|m2ts|ts|flv|wmv|gif|h26[45]|hevc"
"""Pattern of video suffixes."""
_SUFFIX = re.compile(rf"[._-](?:{VIDEO_SUFFIXES})\Z", re.IGNORECASE)
_PUNCTUATION = re.compile(r"[\W_]+")
_UPLOAD_PREFIX = re.compile(
    r"\A(?!(?:19|20)\d\d(?:0[1-9]|1[0-2])(?:0[1-9]|[12]\d|3[01])-)[0-9a-f]{8}-(?![0-9a-f]{8}-)(?=.)", re.ASCII
)
"""Label Studio's prefix of an uploaded file's name; a date does not match, nor does a name with two ids."""


def normalized_name(name: str) -> str:
    """A name without case, punctuation and video suffix, so that all its spellings are equal."""
    return _normalized(_SUFFIX.sub("", name))


def without_upload_prefix(name: str) -> str:
    """A name without Label Studio's upload prefix: eight digits of a UUID and a dash."""
    return _UPLOAD_PREFIX.sub("", name, count=1)


class VideoNameMatcher:
    """Checks whether a name is a spelling of a video's name."""

    def __init__(self, video: DatasetVideo) -> None:
        """Take the video."""
        self._video = video
        stem = Path(video.name).stem
        self._spellings = {_normalized(stem), normalized_name(stem), _normalized(without_upload_prefix(stem))}
        self._spellings.discard("")
        self._cached_find = lru_cache(maxsize=4096)(self._find)

    def __call__(self, name: str) -> bool:
        """Whether ``name``, without its folder, is the video's name, with or without a video suffix."""
        return bool(name) and self._cached_find(name)

    def _find(self, name: str) -> bool:
        without_prefix = without_upload_prefix(name)
        spellings = {
            _normalized(name),
            normalized_name(name),
            _normalized(without_prefix),
            normalized_name(without_prefix),
        }
        return not spellings.isdisjoint(self._spellings) or is_name_of(name, self._video)


def _normalized(name: str) -> str:
    return _PUNCTUATION.sub("-", unicodedata.normalize("NFKC", unquote(name)).casefold()).strip("-")
