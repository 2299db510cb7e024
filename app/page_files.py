"""The files of the browser page: their folder, and a version that identifies their content."""

from __future__ import annotations

import functools
import hashlib
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path


def static_folder() -> Path:
    """Folder of the page: beside ``app`` in a checkout, inside it in a wheel."""
    folder = Path(__file__).resolve().parent
    inside = folder / "static"
    return inside if inside.is_dir() else folder.parent / "static"


def page_version(folder: Path) -> str:
    """Digest of the names and content of the page's files: equal for two installations of one build."""
    return _content_digest(folder, tuple(sorted(_files(folder))))


@functools.lru_cache(maxsize=1)
def _content_digest(folder: Path, files: tuple[str, ...]) -> str:
    """Digest of files as :func:`_files` gives them; read again only when one of them was written."""
    digest = hashlib.sha256()
    for name in (file.partition("\0")[0] for file in files):
        with suppress(FileNotFoundError), (folder / name).open("rb") as content:
            digest.update(f"{name}\0{hashlib.file_digest(content, 'sha256').hexdigest()}\n".encode())
    return digest.hexdigest()[:16]


def _files(folder: Path | str, above: str = "") -> Iterator[str]:
    """Name, size and time of each file below a folder; ``os.scandir``, as each visit reads some hundred of them."""
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir():
                yield from _files(entry.path, f"{above}{entry.name}/")
                continue
            with suppress(FileNotFoundError):  # the lock of an editor is a link to nowhere
                status = entry.stat()
                yield f"{above}{entry.name}\0{status.st_size}\0{status.st_mtime_ns}"
