"""Finds the videos of a batch, and names the folder of each."""

from __future__ import annotations

import glob
import hashlib
import os
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from tsr_engine.batch.task import ANNOTATED_VIDEO, REPORT_FILE
from tsr_engine.errors import InputError
from tsr_engine.io.video_kinds import VIDEO_SUFFIXES

_UNSAFE = re.compile(r"[^\w.-]+")


def find_drives(inputs: Sequence[str]) -> list[Path]:
    """The videos of the inputs as absolute paths, each once, in the order of the inputs.

    Args:
        inputs: files; folders, whose videos are found at any depth by their suffixes; patterns with ``*``, ``?`` or
            ``[...]`` (``**`` crosses folders); and ``@FILE``, a text file with one of these a line, ``#`` for comments.
            Folders and patterns leave out annotated videos of batches, which may be inside.

    Raises:
        InputError: an input matches no video.
    """
    found: dict[Path, None] = {}
    for text in inputs:
        for path in _videos_of_input(text):
            found.setdefault(path.absolute())
    if not found:
        raise InputError("There is no video to track. Name files, folders or patterns.")
    return list(found)


def folder_names(drives: Iterable[Path], known: dict[Path, str]) -> dict[Path, str]:
    """A folder name for each drive: the video's name without suffix; for equal names with digits of the path's hash.

    Names of ``known``, which come from an earlier call, stay.
    """
    names = dict(known)
    new_drives = [path for path in drives if path not in names]
    stems = Counter(_safe_name(path).casefold() for path in new_drives)
    used = {name.casefold() for name in names.values()}
    for path in new_drives:
        name = _safe_name(path)
        if stems[name.casefold()] > 1 or name.casefold() in used:
            name = f"{name}-{hashlib.sha256(os.fsencode(path)).hexdigest()[:12]}"
        used.add(name.casefold())
        names[path] = name
    return names


def _safe_name(path: Path) -> str:
    return _UNSAFE.sub("-", path.stem).strip("-.")[:80] or "drive"


def _videos_of_input(text: str) -> list[Path]:
    if text.startswith("@"):
        return _videos_of_list(Path(text[1:]))
    path = Path(text)
    if path.is_dir():
        found = (p for p in path.rglob("*") if p.suffix.lower() in VIDEO_SUFFIXES and not _is_hidden(p, path))
        videos = sorted(p for p in found if p.is_file() and not _is_result(p))
        if not videos:
            raise InputError(f"{path} has no video. Videos are found by suffixes such as .mp4 or .mkv.")
        return videos
    if path.exists():
        return [path]
    if glob.has_magic(text):
        names = glob.glob(text, recursive=True)  # noqa: PTH207
        matched = sorted(p for p in map(Path, names) if p.is_file() and not _is_result(p))
        if matched:
            return matched
        raise InputError(f"No file matches {text!r}. Check the pattern.")
    raise InputError(f"There is no video at {path}. Check the path.")


def _is_result(path: Path) -> bool:
    """Whether a video is the annotated one of a drive that a batch has tracked."""
    return path.name == ANNOTATED_VIDEO and path.with_name(REPORT_FILE).is_file()


def _is_hidden(path: Path, top: Path) -> bool:
    return any(part.startswith(".") for part in path.relative_to(top).parts)


def _videos_of_list(path: Path) -> list[Path]:
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError:
        raise InputError(f"{path} is not UTF-8 text. Write one video a line.") from None
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}.") from None
    found: list[Path] = []
    for number, line in enumerate(lines, start=1):
        entry = line.strip()
        if not entry or entry.startswith("#"):
            continue
        if entry.startswith("@"):
            raise InputError(f"{path}, line {number}: a list cannot name another list. Write its videos here.")
        try:
            found += _videos_of_input(entry if Path(entry).is_absolute() else str(path.parent / entry))
        except InputError as error:
            raise InputError(f"{path}, line {number}: {error}") from None
    return found
