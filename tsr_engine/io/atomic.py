"""Atomic output files: written under a hidden name in the same folder, then renamed."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, TextIO

from tsr_engine.errors import StorageError, UsageError
from tsr_engine.io.storage_problems import TOO_LARGE_MESSAGE, full_disk_reason, storage_problem
from tsr_engine.io.unfinished import UnfinishedFile


@contextmanager
def atomic_text(path: Path) -> Iterator[TextIO]:
    """A UTF-8 text file that gets its name only when the block ends without an exception and the data is on the disk.

    Missing parent folders are created. After an exception nothing is left behind, and an older file of that name is
    unchanged. If two writers work on one file at a time, the last to end wins.

    Raises:
        StorageError: the folder is not writable, or the disk is full.
    """
    with _atomic(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        yield stream


@contextmanager
def atomic_bytes(path: Path) -> Iterator[BinaryIO]:
    """As ``atomic_text``, for bytes.

    Raises:
        StorageError: the folder is not writable, or the disk is full.
    """
    with _atomic(path) as part, part.open("wb") as stream:
        yield stream


@contextmanager
def _atomic(path: Path) -> Iterator[Path]:
    path = output_path(path)
    try:
        part = UnfinishedFile(path)
        try:
            yield part.path
            part.commit()
        finally:
            part.drop()
    except OSError as error:
        raise storage_error(path, error) from None


def output_path(path: Path) -> Path:
    """The path to which an output is written: a link is kept, and its target is written.

    Missing parent folders are created.

    Raises:
        StorageError: the path is a folder, a device, a pipe or a link to itself, or the parent folder cannot be
            created.
    """
    try:
        path = real_path(path) if path.is_symlink() else path
        if path.is_symlink():
            raise StorageError(f"Cannot write {path}: it is a symbolic link that leads back to itself. Name a file.")
        if path.is_dir():
            raise StorageError(f"Cannot write {path}: it is a folder. Name a file.")
        if path.exists() and not path.is_file():
            raise StorageError(
                f"Cannot write {path}: it is a device or a pipe, which a file would replace. Name a file."
            )
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise storage_error(path, error) from None
    return path


def refuse_unwritable(folder: Path) -> None:
    """Refuse a folder of outputs before long work instead of after it. Creates nothing.

    Args:
        folder: the folder for outputs; it and its parents may be missing.

    Raises:
        StorageError: it is not writable, or cannot be created.
    """
    existing = folder
    try:
        while not existing.exists() and existing != existing.parent:
            existing = existing.parent
        if not existing.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
        UnfinishedFile(existing / "probe").drop()
    except OSError as error:
        raise storage_error(folder, error) from None


def storage_error(path: Path, error: OSError) -> StorageError:
    """Convert a failed write to an error that says what to do."""
    reason = error.strerror or str(error)
    kind = storage_problem(error)
    if kind == "full":
        reason_text = full_disk_reason(error)
        return StorageError(f"Cannot write {path}: {reason_text}. Free some space or choose another folder.", kind)
    if kind == "limit":
        return StorageError(f"Cannot write {path}: {TOO_LARGE_MESSAGE}.", kind)
    if error.errno in (errno.EEXIST, errno.ENOTDIR):
        return StorageError(f"Cannot write {path}: a file stands where a folder is needed. Choose another place.")
    return StorageError(f"Cannot write {path}: {reason}. Choose another place or change its permissions.")


def refuse_inputs(outputs: Iterable[Path | None], inputs: Iterable[Path], input_name: str = "the input itself") -> None:
    """Refuse an output that is one of the inputs, also through links.

    Args:
        outputs: files to be written.
        inputs: files to keep.
        input_name: what the message calls the inputs.

    Raises:
        UsageError: an output names an input.
    """
    sources = list(inputs)
    for output in outputs:
        if output is None:
            continue
        for source in sources:
            is_same = real_path(output) == real_path(source)
            if not is_same and output.exists() and source.exists():
                is_same = output.samefile(source)
            if is_same:
                raise UsageError(f"The output {output} is {input_name}. Choose another name for the output.")


def real_path(path: Path) -> Path:
    """The path without links. A link that leads back to itself stays; ``Path.resolve`` fails on it before 3.13."""
    return Path(os.path.realpath(path))
