"""Names of the files that people download."""

from __future__ import annotations

import re
from pathlib import PurePath

_UNSAFE = re.compile(r"[^\w.-]+")


def file_stem(name: str, otherwise: str) -> str:
    """Make part of a file name from a name: letters of any script, digits, dots and dashes; at most 60 characters.

    Args:
        name: name of a video or person, with or without a suffix of a few letters, which is dropped.
        otherwise: result if nothing is left.
    """
    bare = PurePath(name).stem if re.fullmatch(r"\.\w{1,5}", PurePath(name).suffix) else name
    return _UNSAFE.sub("_", bare)[:60].strip("._-") or otherwise
