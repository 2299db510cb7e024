"""Which files of this machine may be read at all: those inside the allowed folders, and nothing else."""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from app.errors import Invalid, NotFound, Refused
from tsr_engine.io.video_kinds import SUFFIXES

__all__ = ["MOST_ENTRIES", "Listing", "allowed_path", "list_folder"]

MOST_ENTRIES = 2000
"""Folders and videos of one folder that are listed at most."""
_OUTSIDE = "That path lies outside the folders that this server may read. Start it with --root FOLDER to allow another."


def allowed_path(text: str, roots: Sequence[Path]) -> Path:
    """A path that may be read, with links resolved.

    The text is judged before anything on disk is asked about it, and the answer for a path outside is the same
    whether it exists or not.

    Raises:
        Invalid: not an absolute path, or longer than one can be.
        Refused: outside the roots, by itself or through a link; with characters that hide what it is; or of another
            machine (``//server/share``).
    """
    if _odd(text):
        raise Refused("The path holds characters that cannot be in the name of a file here.", field="path")
    if len(text) > 4096 or any(len(os.fsencode(part)) > 255 for part in text.split("/")):
        raise Invalid("The path is longer than that of a file can be. Check it.", field="path")
    if text.startswith(("//", "\\\\")) or ".." in text.split("/"):
        raise Refused(_OUTSIDE, field="path")
    if not text.startswith("/"):
        raise Invalid("The path must be absolute, as in /data/drive.mp4.", field="path")
    plain = Path(os.path.normpath(text))
    if not _inside(plain, roots):
        raise Refused(_OUTSIDE, field="path")
    real = Path(os.path.realpath(plain))
    if not _inside(real, roots):
        raise Refused(_OUTSIDE, field="path")
    return real


def _odd(text: str) -> bool:
    """Control, surrogate and invisible formatting characters: they hide what a name really is."""
    return any(unicodedata.category(c) in ("Cc", "Cs", "Cf") for c in text)


def _inside(path: Path, roots: Sequence[Path]) -> bool:
    return any(path == root or root in path.parents for root in roots)


@dataclass(frozen=True, slots=True)
class Listing:
    """What a folder holds for us."""

    path: Path
    parent: Path | None
    folders: list[str]
    videos: list[tuple[str, Path, int]]
    """Name, path, bytes."""
    truncated: bool
    """There are more than ``MOST_ENTRIES``; these are the first by name."""


def list_folder(text: str, roots: Sequence[Path]) -> Listing:
    """The first ``MOST_ENTRIES`` folders and videos of an allowed folder, by name.

    What is hidden, leads out of the allowed folders or has a name that nobody could ask for is left out and counts as
    little as other files.

    Raises:
        Invalid: see ``allowed_path``; or not a folder.
        Refused: outside the roots.
        NotFound: it is not there or cannot be read.
    """
    folder = allowed_path(text, roots)
    folders: list[str] = []
    videos: list[tuple[str, Path, int]] = []
    truncated = False
    try:
        with os.scandir(folder) as entries:
            for entry in sorted(entries, key=lambda e: e.name.casefold()):
                if entry.name.startswith(".") or _odd(entry.name):
                    continue
                if entry.is_symlink() and not _inside(Path(os.path.realpath(entry.path)), roots):
                    continue
                try:
                    a_folder = entry.is_dir()
                    if not a_folder and not (entry.name.lower().endswith(SUFFIXES) and entry.is_file()):
                        continue
                    size = 0 if a_folder else entry.stat().st_size
                except OSError:
                    continue  # gone meanwhile, or not ours to look at
                if len(folders) + len(videos) == MOST_ENTRIES:
                    truncated = True
                    break
                if a_folder:
                    folders.append(entry.name)
                else:
                    videos.append((entry.name, Path(entry.path), size))
    except NotADirectoryError:
        raise Invalid(f"{folder} is not a folder.", field="path") from None
    except OSError as error:
        raise NotFound(f"{folder} cannot be listed: {error.strerror}.", field="path") from None
    parent = folder.parent if _inside(folder.parent, roots) else None
    return Listing(folder, parent, folders, videos, truncated)
