"""The identity of a server: a random number in its data folder, independent of names of machines and folders.

Shared files have such a number too. A data folder stores it, so it is known while they do not answer.
"""

from __future__ import annotations

import json
import os
import re
import uuid
from pathlib import Path

from app.settings import Settings
from app.storage.database import Database
from tsr_engine.errors import StorageError
from tsr_engine.io.atomic import atomic_text

__all__ = ["BOOT", "database_of", "note_shared", "place_of", "server_id", "shared_of"]

_FILE = "server.id"
_SHARED = "shared.json"
BOOT = Path("/proc/sys/kernel/random/boot_id")


def server_id(home: Path) -> str:
    """The number of a data folder, 32 hexadecimal digits, made on first use.

    Raises:
        StorageError: it cannot be kept, or the file is damaged.
    """
    path = home / _FILE
    try:
        if not path.exists():
            home.mkdir(parents=True, exist_ok=True)
            part = home / f".{_FILE}.{uuid.uuid4().hex}"
            part.write_text(f"{uuid.uuid4().hex}\n", encoding="ascii")
            try:
                path.hardlink_to(part)  # of two that start at once, one is first
            except FileExistsError:
                pass
            finally:
                part.unlink()
        found = path.read_text(encoding="ascii").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise StorageError(f"Cannot keep the server's number in {path}: {error}. Choose another --home.") from None
    if not re.fullmatch("[0-9a-f]{32}", found):
        raise StorageError(f"{path} holds no number of 32 hexadecimal digits. Put it back as it was, or delete it.")
    return found


def database_of(settings: Settings) -> Database:
    """The database of a data folder, as the server of that folder sees it.

    SQLite in the data folder is shared by nobody, so that nothing in it is told apart by servers.
    """
    server = None if settings.database_url is None else server_id(settings.home)
    shared = None if settings.files is None else shared_of(settings.home, settings.files)
    return Database(settings.database, server, shared)


def shared_of(home: Path, address: str) -> str | None:
    """The number of shared files, as it was noted; None: this data folder has not seen them yet."""
    try:
        found = json.loads((home / _SHARED).read_text(encoding="utf-8")).get(address)
    except (OSError, ValueError, AttributeError):
        return None
    return found if isinstance(found, str) else None


def note_shared(home: Path, address: str, number: str) -> None:
    """Note the number of shared files.

    Raises:
        StorageError: the data folder cannot be written.
    """
    with atomic_text(home / _SHARED) as out:
        json.dump({address: number}, out)


def place_of(home: Path) -> str | None:
    """For whom the lock files of a data folder speak: the number, the kernel's present life, and the very folder.

    A copy of the folder has another inode or device, a cloned machine another life of its kernel: their processes hold
    locks that nobody sees here.

    Returns:
        None where the kernel does not tell; then heartbeats alone say who is alive.

    Raises:
        StorageError: see ``server_id``.
    """
    number = server_id(home)
    try:
        boot, status = BOOT.read_text(encoding="ascii").strip(), os.stat(home / _FILE)  # noqa: PTH116 - all of it
    except OSError:
        return None
    return f"{number}:{boot}:{status.st_dev:x}.{status.st_ino:x}" if boot else None
