"""Names the videos of an export in its file names, and finds the video for such a name."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from tsr_engine.exchange.dataset import DatasetVideo

_UNSAFE = re.compile(r"[^A-Za-z0-9.-]+")
_HASH_DIGIT_COUNTS = (8, 16, 64)
"""Number of hash digits after a video's name; more are taken if needed."""
_HEX = frozenset("0123456789abcdef")


def safe_stem(name: str) -> str:
    """A video's name as part of file names: letters, digits, dots and dashes; at most 60 characters, never empty."""
    return _UNSAFE.sub("-", Path(name).stem).strip("-.")[:60] or "video"


def video_names(videos: Sequence[DatasetVideo]) -> list[str]:
    """A name for each video, all different without regard to case.

    Videos that share a name get the first digits of their SHA-256 after it. So a name does not depend on the order of
    the videos and identifies its video. Only videos without a hash, or one video twice, are
    numbered.
    """
    stems = [safe_stem(video.name) for video in videos]
    folded = [stem.casefold() for stem in stems]
    is_shared = [folded.count(name) > 1 for name in folded]
    for digits in _HASH_DIGIT_COUNTS:
        out = [
            f"{stem}-{video.sha256[:digits]}" if shared and video.sha256 else stem
            for stem, video, shared in zip(stems, videos, is_shared, strict=True)
        ]
        if _are_unique(out):
            return out
    paired = zip(stems, is_shared, strict=True)
    out = [f"{stem}-{position}" if shared else stem for position, (stem, shared) in enumerate(paired, start=1)]
    return out if _are_unique(out) else [f"{position}-{stem}" for position, stem in enumerate(stems, start=1)]


def picture_prefixes(videos: Sequence[DatasetVideo]) -> list[str]:
    """Prefix of picture names for each video: empty for a single video, else its name and ``_``."""
    return [""] if len(videos) == 1 else [f"{name}_" for name in video_names(videos)]


def is_name_of(name: str, video: DatasetVideo) -> bool:
    """Whether a name is the video's own, alone or with the first digits of its SHA-256."""
    if name.casefold() == safe_stem(video.name).casefold():
        return True
    digits = _hash_digits(name, video)
    return len(digits) in _HASH_DIGIT_COUNTS and video.sha256.casefold().startswith(digits)


def is_name_of_namesake(name: str, video: DatasetVideo) -> bool:
    """Whether a name is that of another video of the same name: it ends in digits of another SHA-256."""
    digits = _hash_digits(name, video)
    return len(digits) in _HASH_DIGIT_COUNTS and set(digits) <= _HEX and not video.sha256.casefold().startswith(digits)


def _hash_digits(name: str, video: DatasetVideo) -> str:
    stem, name = safe_stem(video.name).casefold(), name.casefold()
    return name.removeprefix(f"{stem}-") if name.startswith(f"{stem}-") else ""


def _are_unique(names: list[str]) -> bool:
    return len({name.casefold() for name in names}) == len(names)
