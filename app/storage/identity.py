"""The id of a server: a random number in its data folder, independent of names of machines and folders.

Shared files have such an id too. A data folder stores it, so that it is known while they do not answer.
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

_FILE = "server.id"
_SHARED = "shared.json"
BOOT_ID_FILE = Path("/proc/sys/kernel/random/boot_id")


def server_id(home: Path) -> str:
    """Return the id of a data folder, 32 hexadecimal digits, made on first use.

    Raises:
        StorageError: it cannot be stored, or the file is damaged.
    """
    path = home / _FILE
    try:
        if not path.exists():
            home.mkdir(parents=True, exist_ok=True)
            part = home / f".{_FILE}.{uuid.uuid4().hex}"
            part.write_text(f"{uuid.uuid4().hex}\n", encoding="ascii")
            try:
                path.hardlink_to(part)  # if two servers start at once, one writes it first
            except FileExistsError:
                pass
            finally:
                part.unlink()
        text = path.read_text(encoding="ascii").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise StorageError(f"Cannot store the server's id in {path}: {error}. Choose another --home.") from None
    if not re.fullmatch("[0-9a-f]{32}", text):
        raise StorageError(f"{path} does not contain an id of 32 hexadecimal digits. Restore it, or delete it.")
    return text


def open_database(settings: Settings) -> Database:
    """Open the database of a data folder as its server sees it.

    SQLite in the data folder has only one server, so its rows carry no server.
    """
    server = None if settings.database_url is None else server_id(settings.home)
    shared = None if settings.files is None else stored_shared_id(settings.home, settings.files)
    return Database(settings.database, server, shared)


def stored_shared_id(home: Path, address: str) -> str | None:
    """Return the stored id of shared files; None: this data folder has not used them yet."""
    try:
        text = json.loads((home / _SHARED).read_text(encoding="utf-8")).get(address)
    except (OSError, ValueError, AttributeError):
        return None
    return text if isinstance(text, str) else None


def store_shared_id(home: Path, address: str, number: str) -> None:
    """Store the id of shared files.

    Raises:
        StorageError: the data folder cannot be written.
    """
    with atomic_text(home / _SHARED) as out:
        json.dump({address: number}, out)


def lock_place(home: Path) -> str | None:
    """Identify where lock files of a data folder are visible: its id, the kernel's boot, and the folder itself.

    A copy of the folder has another inode or device, a cloned machine another boot id: locks of their processes are not
    visible here.

    Returns:
        None if the kernel does not tell its boot id; then only heartbeats show which processes are alive.

    Raises:
        StorageError: see ``server_id``.
    """
    number = server_id(home)
    try:
        boot, status = BOOT_ID_FILE.read_text(encoding="ascii").strip(), os.stat(home / _FILE)  # noqa: PTH116 - all of it
    except OSError:
        return None
    return f"{number}:{boot}:{status.st_dev:x}.{status.st_ino:x}" if boot else None
