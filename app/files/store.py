"""The shared files: finished files and folders, written and read as a whole.

Each entry lies under its name, beside a list of its files with their sizes and SHA-256. The list is written last; an
entry without a list does not exist. Files that are read back must have the sizes and hashes of the list.
"""

from __future__ import annotations

import errno
import hashlib
import json
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Final

from app.errors import Busy
from tsr_engine.errors import StorageError, TsrError
from tsr_engine.extras import explained
from tsr_engine.io.digest import file_sha256
from tsr_engine.io.unfinished import fsync_path

if TYPE_CHECKING:
    from fsspec import AbstractFileSystem

_ID_FILE: Final = "store.id"
_MAX_LIST_BYTES: Final = 16 * 2**20
S3_LIMITS: Final = {"connect_timeout": 5, "read_timeout": 20, "retries": {"max_attempts": 2, "mode": "standard"}}
"""Limits of S3: seconds to connect, seconds without a byte, number of retries; slow storage needs that patience."""
PROBE_LIMITS: Final = {"connect_timeout": 4, "read_timeout": 4, "retries": {"total_max_attempts": 1}}
"""Limits of :meth:`SharedStore.require_answer`, whose answer is a few bytes."""
_DENIED_ERRORS: Final = (
    "NoCredentials", "PartialCredentials", "InvalidAccessKeyId", "SignatureDoesNotMatch", "AccessDenied",
)  # fmt: skip
_TIMEOUT_ERRORS: Final = (
    "Timeout", "EndpointConnection", "ConnectionClosed", "ConnectionError", "ConnectorError", "HTTPClient",
)  # fmt: skip

FileList = Mapping[str, tuple[int, str]]
"""Files of an entry, relative to its name (empty for a single file) -> bytes and SHA-256."""


class SharedFilesError(Busy, StorageError):
    """The shared files do not answer, deny access, are full, or are damaged."""


class SharedStore:
    """One place of shared files; thread-safe.

    Args:
        address: ``s3://BUCKET/PREFIX``, ``file:///FOLDER``, or a folder.

    Attributes:
        address: the address as given.
        system: the file system of fsspec behind it.

    Raises:
        UsageError: no such address.
        MissingExtra: the package for its file system is not installed.
    """

    def __init__(self, address: str) -> None:
        with explained():
            import fsspec
        self.address = address
        self._local = not address.startswith("s3://")
        self.system: AbstractFileSystem
        if self._local:
            self.system = fsspec.filesystem("file")
        else:
            options = {"skip_instance_cache": True, "use_listings_cache": False}
            with explained():
                self.system = fsspec.filesystem("s3", **options, config_kwargs=S3_LIMITS)
                self._probe = fsspec.filesystem("s3", **options, config_kwargs=PROBE_LIMITS)
            self.system.retries = self._probe.retries = 1  # botocore's tries (S3_LIMITS) are enough
        self._root = str(self.system._strip_protocol(address)).rstrip("/")

    def store_id(self, known: str | None) -> str:
        """Return the random id of the place, 32 hexadecimal digits; made on first use.

        Args:
            known: its id when this server last used it.

        Raises:
            SharedFilesError: it does not answer.
            StorageError: it has another id, or no longer any: another folder is mounted there.
        """
        with self._explained(""):
            if self._local and not Path(self._root).is_dir():
                raise StorageError(f"The folder {self._root} of the shared files does not exist. Make it, or mount it.")
            found = self._read_id()
            if found is None and known is None:
                with suppress(FileExistsError):  # if two servers start at once, one writes it first
                    self.system.pipe_file(self.path(_ID_FILE), uuid.uuid4().hex.encode(), mode="create")
                found = self._read_id()
        if found is None or (known is not None and found != known):
            raise StorageError(
                f"{self.address} does not hold the shared files that this server knows ({_ID_FILE} is missing or "
                "another one). Mount the right folder. If they have moved for good, delete shared.json in the data "
                "folder."
            )
        return found

    def require_answer(self) -> None:
        """Ask the place a small question while something else takes long there; a folder is not asked.

        Raises:
            SharedFilesError: it does not answer within 4 seconds.
        """
        if not self._local:
            with self._explained(""), suppress(FileNotFoundError):
                self._probe.info(self.path(_ID_FILE))

    def put(self, name: str, source: Path, wait: Callable[[], None] = lambda: None) -> FileList:
        """Store a finished file or folder as a whole; it replaces an entry of that name.

        Args:
            name: name of the entry, such as ``runs/0123``.
            source: local path; it must not change meanwhile.
            wait: called between files; may raise.

        Returns:
            Its files.

        Raises:
            SharedFilesError: it could not be stored.
            OSError: the source cannot be read.
        """
        files = {inside: (path.stat().st_size, file_sha256(path)) for inside, path in files_of(source).items()}
        with self._explained(name):
            self._drop(name)
            try:
                for inside in files:
                    wait()
                    target = self.path(name, inside)
                    if self._local:
                        Path(target).parent.mkdir(parents=True, exist_ok=True)
                    self.system.put_file(str(source / inside), target)
                    if self._local:
                        fsync_path(Path(target))
                text = json.dumps({"format": 1, "files": {inside: list(entry) for inside, entry in files.items()}})
                self.system.pipe_file(self.path(f"{name}.json"), text.encode())
            except BaseException:
                with suppress(Exception):
                    self._drop(name)  # on a full disk an incomplete entry would take up room
                raise
        return files

    def list_files(self, name: str) -> FileList:
        """Read the list of an entry.

        Raises:
            SharedFilesError: the entry does not exist, or its list is damaged.
        """
        with self._explained(name):
            text = self.system.cat_file(self.path(f"{name}.json"), end=_MAX_LIST_BYTES)
        try:
            files = json.loads(text)["files"]
            found = {str(inside): (int(size), str(digest)) for inside, (size, digest) in files.items()}
            if any(inside.startswith("/") or ".." in Path(inside).parts for inside in found):
                raise ValueError(name)
        except (ValueError, KeyError, TypeError, AttributeError):
            raise self._damaged(f"{name}.json") from None
        return found

    def is_complete(self, name: str) -> bool:
        """Whether an entry exists with all its files, by their sizes."""
        files = self.list_files(name)
        with self._explained(name):
            return all(self.system.info(self.path(name, inside))["size"] == size for inside, (size, _) in files.items())

    def get(self, name: str, files: FileList, part: Path) -> None:
        """Copy an entry to ``part``, which is incomplete until this returns.

        Args:
            name: name of the entry.
            files: its list, from :meth:`list_files`.
            part: file or folder to write; must not exist.

        Raises:
            SharedFilesError: it cannot be read, or its bytes differ from the list.
            OSError: it cannot be written here.
        """
        for inside, (size, digest) in files.items():
            path, content = part / inside, hashlib.sha256()
            path.parent.mkdir(parents=True, exist_ok=True)
            with (
                path.open("wb") as target,
                self._explained(name),
                self.system.open(self.path(name, inside), "rb") as source,
            ):
                while piece := source.read(2**20):
                    content.update(piece)
                    _write(target, piece)
            if path.stat().st_size != size or content.hexdigest() != digest:
                raise self._damaged(f"{name}/{inside}".rstrip("/"))
            fsync_path(path)

    def remove(self, name: str) -> None:
        """Remove an entry, if it exists.

        Raises:
            SharedFilesError: it cannot be removed now.
        """
        with self._explained(name):
            self._drop(name)

    def path(self, name: str, inside: str = "") -> str:
        """Path of an entry, or of one of its files, in the file system."""
        return "/".join(part for part in (self._root, name, inside) if part)

    # ------------------------------------------------------------------------------------------------------ inside

    def _read_id(self) -> str | None:
        try:
            return str(self.system.cat_file(self.path(_ID_FILE), end=64).decode("ascii", "replace")).strip()
        except FileNotFoundError:
            if not self._local:  # a missing bucket is handled elsewhere
                self.system.ls(self._root.partition("/")[0], refresh=True)
            return None

    def _drop(self, name: str) -> None:
        for path, recursive in ((self.path(f"{name}.json"), False), (self.path(name), True)):
            with suppress(FileNotFoundError):
                self.system.rm(path, recursive=recursive)

    def _damaged(self, what: str) -> SharedFilesError:
        return SharedFilesError(
            f"{what} in the shared files ({self.address}) is damaged: its bytes have changed. Restore it from a "
            "backup, or remove it here and make it again.",
            code="files_damaged",
        )

    @contextmanager
    def _explained(self, name: str) -> Iterator[None]:
        """Convert failures to one message.

        A folder that is not mounted looks like an empty folder, which must not be written to.
        """
        try:
            if name and self._local and not Path(self.path(_ID_FILE)).is_file():
                raise SharedFilesError(
                    f"The folder of the shared files ({self.address}) is missing. Mount it again.", code="files_away"
                )
            yield
        except (TsrError, _WriteError):
            raise
        except Exception as error:
            raise SharedFilesError(self._message(name, error), code="files_away") from error

    def _message(self, name: str, error: Exception) -> str:
        where = f"The shared files ({self.address})"
        names = " ".join(type(one).__name__ for one in _causes(error)) + f" {error}"
        number = error.errno if isinstance(error, OSError) else None
        if number in (errno.ENOSPC, errno.EDQUOT):
            return f"{where} are full. Free some space there."
        if number == errno.EROFS:
            return f"{where} can only be read. Let this server write there."
        if isinstance(error, FileNotFoundError) and ("bucket" in str(error).lower() or not name):
            return f"{where}: there is no such bucket. Make it, or correct TSR_FILES."
        if isinstance(error, FileNotFoundError):
            return f"{where} no longer hold {name}. Restore it from a backup, or remove it here and make it again."
        if isinstance(error, PermissionError) or any(word in names for word in _DENIED_ERRORS):
            return f"{where} deny access. Check this server's rights, and for S3 its credentials (AWS_ACCESS_KEY_ID)."
        if isinstance(error, TimeoutError) or any(word in names for word in _TIMEOUT_ERRORS):
            return f"{where} do not answer. Repeat the request later."
        return f"{where} cannot be used: {error or type(error).__name__}."


class _WriteError(OSError):
    """The local file cannot be written; the shared files are not at fault."""


def _write(target: BinaryIO, piece: bytes) -> None:
    try:
        target.write(piece)
    except OSError as error:
        raise _WriteError(error.errno, error.strerror) from error


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def files_of(source: Path) -> dict[str, Path]:
    """List the files to store of a file or folder, without locks and SQLite's auxiliary files.

    Returns:
        Name relative to the source (empty for a file) -> the file.

    Raises:
        FileNotFoundError: the source does not exist.
    """
    if source.is_file():
        return {"": source}
    found = {str(path.relative_to(source)): path for path in sorted(source.rglob("*")) if path.is_file()}
    kept = {
        inside: path
        for inside, path in found.items()
        if not inside.endswith((".lock", "-shm")) and not (inside.endswith("-wal") and not path.stat().st_size)
    }
    if not kept:
        raise FileNotFoundError(errno.ENOENT, "nothing is there", str(source))
    return kept
