"""Names of the files that people download."""

from __future__ import annotations

import re
from pathlib import PurePath

__all__ = ["file_stem"]

_UNSAFE = re.compile(r"[^\w.-]+")


def file_stem(name: str, otherwise: str) -> str:
    """A video's or a person's name as part of a file name: letters of any script, digits, dots, dashes; at most 60.

    Args:
        name: with or without a suffix of a few letters, which is left out.
        otherwise: what it is called where nothing is left.
    """
    bare = PurePath(name).stem if re.fullmatch(r"\.\w{1,5}", PurePath(name).suffix) else name
    return _UNSAFE.sub("_", bare)[:60].strip("._-") or otherwise
