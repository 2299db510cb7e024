"""Decides which files of this machine may be read: those inside the allowed folders."""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from app.errors import Invalid, NotFound, Refused
from app.videos.safe_open import LINK_ERRORS, open_inside, resolve_links
from tsr_engine.io.opened_file import OpenedFile, unreadable_message
from tsr_engine.io.video_kinds import VIDEO_SUFFIXES

MAX_ENTRIES = 2000
"""Maximum number of listed folders and videos of one folder."""
_SCAN_THRESHOLD = 16
"""Number of files of one folder from which on the folder is read instead of checking each file."""
_OUTSIDE = "That path lies outside the folders that this server may read. Start it with --root FOLDER to allow another."


def allowed_path(text: str, roots: Sequence[Path]) -> Path:
    """Return a path that may be read, with links resolved.

    The text is checked before the disk is accessed, and the error for a path outside is the same whether it exists or
    not.

    Raises:
        Invalid: the path is not absolute, or too long.
        Refused: it is outside the roots, by itself or through a link; has characters that hide its real name; or names
            another machine (``//server/share``).
    """
    if _has_hidden_characters(text):
        raise Refused("The path contains characters that are not allowed in file names here.", field="path")
    if len(text) > 4096 or any(len(os.fsencode(part)) > 255 for part in text.split("/")):
        raise Invalid("The path is too long. Check it.", field="path")
    if text.startswith(("//", "\\\\")) or ".." in text.split("/"):
        raise Refused(_OUTSIDE, field="path")
    if not text.startswith("/"):
        raise Invalid("The path must be absolute, as in /data/drive.mp4.", field="path")
    plain = Path(os.path.normpath(text))
    if not _inside(plain, roots):
        raise Refused(_OUTSIDE, field="path")
    real = resolve_links(plain)
    if not _inside(real, roots):
        raise Refused(_OUTSIDE, field="path")
    return real


def _has_hidden_characters(text: str) -> bool:
    """Whether a character is a control, surrogate or invisible formatting character, which hides the real name."""
    return any(unicodedata.category(c) in ("Cc", "Cs", "Cf") for c in text)


def root_of(path: Path, roots: Sequence[Path]) -> Path | None:
    """Return the root that contains a path, compared as text; None: none."""
    return next((root for root in roots if path.is_relative_to(root)), None)


def _inside(path: Path, roots: Sequence[Path]) -> bool:
    return root_of(path, roots) is not None


def open_allowed(text: str, roots: Sequence[Path]) -> OpenedFile:
    """Open a path that may be read; a link that is placed in the path meanwhile is refused too.

    Raises:
        Invalid, Refused: see ``allowed_path``.
        NotFound: it does not exist or cannot be read.
    """
    real = allowed_path(text, roots)
    root = root_of(real, roots)
    assert root is not None
    try:
        return OpenedFile(open_inside(root, real), real)
    except OSError as error:
        if error.errno in LINK_ERRORS:
            raise Refused(_OUTSIDE, field="path") from None
        if isinstance(error, FileNotFoundError | NotADirectoryError):
            raise NotFound(f"There is no file {real}.", field="path") from None
        raise Invalid(unreadable_message(real, error), field="path", code="not_a_video") from None


@dataclass(frozen=True, slots=True)
class Listing:
    """Videos and folders in a folder."""

    path: Path
    parent: Path | None
    folders: list[str]
    videos: list[tuple[str, Path, int]]
    """Name, path, bytes."""
    truncated: bool
    """Whether there are more than ``MAX_ENTRIES``; these are the first by name."""


def list_folder(text: str, roots: Sequence[Path]) -> Listing:
    """List the first ``MAX_ENTRIES`` folders and videos of an allowed folder, by name.

    Hidden entries, links out of the allowed folders and names that no request could contain are left out, like other
    files.

    Raises:
        Invalid: see ``allowed_path``; or it is not a folder.
        Refused: it is outside the roots.
        NotFound: it does not exist or cannot be read.
    """
    folder = allowed_path(text, roots)
    root = root_of(folder, roots)
    assert root is not None
    folders: list[str] = []
    videos: list[tuple[str, Path, int]] = []
    truncated = False
    try:
        descriptor = open_inside(root, folder, os.O_DIRECTORY)
    except NotADirectoryError:
        raise Invalid(f"{folder} is not a folder.", field="path") from None
    except OSError as error:
        if error.errno in LINK_ERRORS:
            raise Refused(_OUTSIDE, field="path") from None
        raise NotFound(f"{folder} cannot be listed: {error.strerror}.", field="path") from None
    try:
        with os.scandir(descriptor) as entries:
            for entry in sorted(entries, key=lambda e: e.name.casefold()):
                if entry.name.startswith(".") or _has_hidden_characters(entry.name):
                    continue
                if entry.is_symlink() and not _inside(resolve_links(folder / entry.name), roots):
                    continue
                try:
                    is_folder = entry.is_dir()
                    if not is_folder and not (entry.name.lower().endswith(VIDEO_SUFFIXES) and entry.is_file()):
                        continue
                    size = 0 if is_folder else entry.stat().st_size
                except OSError:
                    continue  # removed meanwhile, or not readable
                if len(folders) + len(videos) == MAX_ENTRIES:
                    truncated = True
                    break
                if is_folder:
                    folders.append(entry.name)
                else:
                    videos.append((entry.name, folder / entry.name, size))
    finally:
        os.close(descriptor)
    parent = folder.parent if _inside(folder.parent, roots) else None
    return Listing(folder, parent, folders, videos, truncated)


def existing_files(paths: Sequence[str]) -> set[str]:
    """Return those of some absolute paths that are files. A folder with many of them is read once, which is faster."""
    folders: dict[str, list[str]] = {}
    for path in paths:
        folders.setdefault(os.path.dirname(path), []).append(path)  # noqa: PTH120 - of ten thousand texts
    found: set[str] = set()
    for folder, wanted in folders.items():
        if len(wanted) < _SCAN_THRESHOLD:
            found.update(path for path in wanted if os.path.isfile(path))  # noqa: PTH113 - as above
            continue
        with suppress(OSError), os.scandir(folder) as entries:
            names = {f"{folder.rstrip('/')}/{entry.name}": entry for entry in entries}
            found.update(path for path in wanted if path in names and names[path].is_file())
    return found
