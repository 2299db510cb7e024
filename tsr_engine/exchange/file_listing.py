"""Lists the files in a folder."""

from __future__ import annotations

import os
from pathlib import Path


def list_files(folder: Path) -> list[str]:
    """Names of all files below a folder, relative, with slashes, sorted; plain strings, as there can be 100,000."""
    out: list[str] = []
    pending = [""]
    while pending:
        prefix = pending.pop()
        with os.scandir(f"{folder}/{prefix}") as entries:
            for entry in entries:
                if entry.is_dir(follow_symlinks=False):
                    pending.append(f"{prefix}{entry.name}/")
                elif entry.is_file(follow_symlinks=False):
                    out.append(prefix + entry.name)
    return sorted(out)


def head_of(file: Path, size: int = 1 << 14) -> bytes:
    """The first ``size`` bytes of a file."""
    with file.open("rb") as stream:
        return stream.read(size)


def first_row(file: Path) -> str:
    """The first line of a text file that is not empty, of the first 4096 bytes; empty: there is none."""
    return next((line for line in head_of(file, 1 << 12).decode("latin-1").splitlines() if line.strip()), "")


def is_system_file(name: str) -> bool:
    """Whether an operating system left the file, by its name with slashes; macOS writes a ``._`` twin of many files."""
    first, _, _ = name.partition("/")
    last = name.rsplit("/", 1)[-1]
    return first == "__MACOSX" or last.startswith("._") or last in (".DS_Store", "Thumbs.db", "desktop.ini")


def list_json_files(path: Path) -> list[Path]:
    """The JSON annotations of a folder, sorted, or the file itself; Roboflow has one in the folder of each subset."""
    if path.is_file():
        return [path]
    for pattern in ("annotations/*.json", "*.json", "*/*.json"):
        found = sorted(file for file in path.glob(pattern) if file.name != "manifest.json")
        found = [file for file in found if not is_system_file(file.relative_to(path).as_posix())]
        if found:
            return found
    return []
