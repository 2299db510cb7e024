"""Unpacks ZIP archives that are not trusted, and packs folders into the same bytes on every machine.

Limits are checked against the bytes that are unpacked: the sizes that an archive announces may be false.
"""

from __future__ import annotations

import io
import os
import re
import stat
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from tsr_engine.errors import ImportFormatError, ImportProblem
from tsr_engine.exchange.file_listing import is_system_file, list_files
from tsr_engine.exchange.small_file_store import SmallFileStore
from tsr_engine.exchange.untrusted_zip import ArchiveLimits, open_zip
from tsr_engine.exchange.zip_writer import ZipWriter
from tsr_engine.io.pictures import SUFFIXES

__all__ = ["ArchiveLimits", "pack", "unpack"]

_CHUNK_BYTES = 1 << 20
_ARCHIVE_SUFFIXES = (
    *(".zip", ".7z", ".rar", ".tar", ".gz", ".tgz", ".bz2", ".tbz", ".tbz2", ".xz", ".txz", ".zst", ".lz", ".jar"),
)
_ARCHIVE_SIGNATURES = (
    *(b"PK\x03\x04", b"7z\xbc\xaf\x27\x1c", b"Rar!\x1a\x07", b"\x1f\x8b\x08", b"BZh", b"\xfd7zXZ\x00"),
    b"\x28\xb5\x2f\xfd",
)
_CONTROL = re.compile("[\0-\x1f]")
_ANY_RATIO_BYTES = 1 << 20
"""Entries up to this many bytes may unfold at any ratio: a file of zeros is no attack."""


def unpack(
    path: Path,
    folder: Path,
    *,
    limits: ArchiveLimits | None = None,
    pictures: bool = True,
    store: SmallFileStore | None = None,
) -> list[str]:
    """Unpack a ZIP archive into an empty folder.

    Args:
        path: the ZIP file.
        folder: exists and is empty.
        limits: of the unpacked files; unset: ``ArchiveLimits()``.
        pictures: False: skip pictures, which an import of annotations does not read.
        store: takes most of many small files, which are then missing in ``folder``.

    Returns:
        Names of the unpacked files, relative to ``folder``.

    Raises:
        ImportFormatError: the archive exceeds a limit, is damaged or encrypted, or has an unsafe name or kind of entry;
            names the entry and the rule. ``folder`` may then hold some of the files.
    """
    limits = ArchiveLimits() if limits is None else limits
    with open_zip(path, limits) as archive:
        return _unpack(archive, path, folder, limits, pictures, store)


def pack(folder: Path, target: BinaryIO, progress: Callable[[], None] = lambda: None) -> None:
    """Pack a folder with sorted names and fixed dates and permissions, so that equal files give equal bytes.

    Args:
        folder: all its files are packed, with names relative to it.
        target: an open, empty file.
        progress: called after each megabyte; may raise to stop.
    """
    with ZipWriter(target, progress) as archive:
        for name in list_files(folder):
            with (folder / name).open("rb", buffering=0) as stream:
                archive.put_stream(name, stream, os.fstat(stream.fileno()).st_size)


def _unpack(
    archive: zipfile.ZipFile,
    path: Path,
    folder: Path,
    limits: ArchiveLimits,
    pictures: bool,
    store: SmallFileStore | None,
) -> list[str]:
    entries = archive.infolist()
    used_names: set[str] = set()
    chosen: list[tuple[zipfile.ZipInfo, str]] = []
    for entry in entries:
        name = _safe_name(path, entry)
        if name.casefold() in used_names:
            raise _refuse(path, entry, "occurs twice")
        if name and not is_system_file(name):
            used_names.add(name.casefold())
            if not entry.is_dir() and (pictures or name[name.rfind(".") :].lower() not in SUFFIXES):
                chosen.append((entry, name))
    total = 0
    created_folders: set[str] = set()
    for entry, name in chosen:
        try:
            if store is not None and store.accepts(name, entry.file_size):
                content = io.BytesIO()
                with archive.open(entry) as source:
                    total += _copy(path, entry, source, content, total, limits)
                store.put(name, content.getvalue())
                continue
            # Plain names: with 100,000 entries, Path objects and folder lookups take a third of the time.
            parent = name.rpartition("/")[0]
            if parent not in created_folders:
                (folder / parent).mkdir(parents=True, exist_ok=True)
                created_folders.add(parent)
            with archive.open(entry) as source, open(f"{folder}/{name}", "xb") as out:  # noqa: PTH123
                total += _copy(path, entry, source, out, total, limits)
        except (FileExistsError, NotADirectoryError):
            raise _refuse(path, entry, "is a file and a folder at once") from None
        except RuntimeError:
            raise _refuse(path, entry, "is encrypted") from None
    if store is not None:
        store.flush_content()
    return [name for _, name in chosen]


def _copy(
    path: Path, entry: zipfile.ZipInfo, source: object, out: BinaryIO, earlier_bytes: int, limits: ArchiveLimits
) -> int:
    copied = 0
    packed = max(entry.compress_size, 1)
    while chunk := source.read(_CHUNK_BYTES):  # type: ignore[attr-defined]
        if copied == 0 and chunk.startswith(_ARCHIVE_SIGNATURES):
            raise _refuse(path, entry, "is an archive within the archive")
        copied += len(chunk)
        if copied > limits.single:
            raise _refuse(path, entry, f"unfolds to more than {limits.single} bytes", "too_large")
        if earlier_bytes + copied > limits.total:
            raise _refuse(path, entry, f"brings the archive to more than {limits.total} bytes", "too_large")
        if copied > _ANY_RATIO_BYTES and copied / packed > limits.ratio:
            raise _refuse(path, entry, f"unfolds to more than {limits.ratio} times its packed size", "too_large")
        out.write(chunk)
    return copied


def _safe_name(path: Path, entry: zipfile.ZipInfo) -> str:
    """The entry's name as a relative path with slashes; empty for the top folder itself."""
    name = entry.filename
    if entry.flag_bits & 0x1:
        raise _refuse(path, entry, "is encrypted")
    kind = stat.S_IFMT(entry.external_attr >> 16)
    if kind not in (0, stat.S_IFREG, stat.S_IFDIR):
        raise _refuse(path, entry, "is a link or another special file", "unsafe")
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise _refuse(path, entry, "uses a compression other than deflate")
    # zipfile cuts a name at a NUL; orig_filename keeps the whole name.
    if "\0" in entry.orig_filename or _CONTROL.search(name):
        raise _refuse(path, entry, "has control characters in its name", "unsafe")
    if name.startswith("/") or "\\" in name or name[1:2] == ":":
        raise _refuse(path, entry, "has an absolute name or one of another system", "unsafe")
    parts = [part for part in name.split("/") if part not in ("", ".")]
    if ".." in parts:
        raise _refuse(path, entry, "leads out of its folder", "unsafe")
    if len(parts) > 32 or (len(name) > 63 and any(len(part.encode("utf-8", "replace")) > 255 for part in parts)):
        raise _refuse(path, entry, "has a name that is too long")
    if parts and not entry.is_dir() and parts[-1].lower().endswith(_ARCHIVE_SUFFIXES):
        raise _refuse(path, entry, "is an archive within the archive")
    return "/".join(parts)


def _refuse(path: Path, entry: zipfile.ZipInfo, rule: str, kind: ImportProblem = "broken") -> ImportFormatError:
    name = ascii(entry.filename[:120])[1:-1]
    advice = "Pack only the annotation files, as they are."
    return ImportFormatError(f"{path.name}: the entry {name} {rule}. {advice}", kind)
