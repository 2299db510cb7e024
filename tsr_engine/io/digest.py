"""The SHA-256 of a file, which identifies videos, outputs and the parts of bundles."""

from __future__ import annotations

import hashlib
from pathlib import Path


def file_sha256(path: Path) -> str:
    """SHA-256 of a file's bytes, hex; the file is read piece by piece.

    Raises:
        OSError: the file is missing or cannot be read.
    """
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
