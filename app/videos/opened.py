"""Opens files of videos; checks root, identity and hash each time.

No other module of ``app`` opens a video by its name (``tests/architecture/test_opened_videos.py``). Callers get a
descriptor: see :mod:`tsr_engine.io.opened_file`.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Sequence
from pathlib import Path

from app.files.shared import shared_files
from app.settings import Settings
from app.storage.models import Video
from app.videos.beneath import LINKS, open_beneath, resolved
from app.videos.paths import open_allowed, root_of
from sample_videos import SHIPPED
from tsr_engine.errors import VideoError
from tsr_engine.io.opened_file import OpenedFile, Stamp, stamp_of, unreadable
from tsr_engine.io.video_probe import check_file

__all__ = [
    "ChangedError",
    "CheckedFile",
    "check_file",
    "library_file",
    "open_allowed",
    "own_file",
    "roots_of",
    "stamp_now",
]


class ChangedError(VideoError):
    """The file's bytes do not match the hash that identifies the video."""


def roots_of(settings: Settings) -> list[Path]:
    """Folders that videos may be added from, links resolved; the bundled drives' is always among them."""
    return [*settings.roots, Path(os.path.realpath(SHIPPED[0].video.parent))]


class CheckedFile:
    """A file that is checked each time it is opened; thread-safe, and a ``VideoSource`` for the engine.

    Attributes:
        path: where it lies.
        stamp: how it stood when its bytes were last compared; None: never.
    """

    def __init__(
        self, path: Path, roots: Sequence[Path], digest: str | None = None, stamp: Stamp | None = None
    ) -> None:
        """Name the file; it is not opened yet.

        Args:
            path: absolute. Outside the roots it is one that was resolved when it was added, under roots of an earlier
                start: no part of it may be a link by now.
            roots: folders in which links are followed, as long as they stay there; links resolved.
            digest: SHA-256 that its bytes must have; None: it is a file that only the server writes.
            stamp: as above.
        """
        self.path = path
        self.stamp = stamp
        self._roots = roots
        self._digest = digest

    def __str__(self) -> str:
        return str(self.path)

    @property
    def roots(self) -> Sequence[Path]:
        """Folders in which links are followed."""
        return self._roots

    @property
    def digest(self) -> str | None:
        """SHA-256 that the bytes must have."""
        return self._digest

    @property
    def there(self) -> bool:
        """Whether there is a file of that name at all; says nothing about whether it is the video."""
        return self.path.is_file()

    def open(self) -> OpenedFile:
        """Open it; its bytes are read where somebody has touched it since they were last compared.

        Raises:
            ChangedError: it holds other bytes.
            VideoError: it is missing, cannot be read, or a link is on the way.
        """
        file = self._open()
        try:
            before = file.stamp
            if self._digest is not None and before != self.stamp:
                if file.sha256() != self._digest:
                    raise ChangedError(f"{self.path} has changed since it was added. {_PUT_BACK}")
                if file.stamp != before:
                    raise ChangedError(f"{self.path} was written to while it was read. {_PUT_BACK}")
                self.stamp = before
        except BaseException:
            file.close()
            raise
        return file

    def _open(self) -> OpenedFile:
        real = resolved(self.path)
        root = root_of(real, self._roots)
        place = self.path if root is None else real
        try:
            return OpenedFile(open_beneath(root or Path("/"), place), self.path)
        except OSError as error:
            if error.errno in LINKS:
                raise VideoError(
                    f"{self.path} leads through a link out of the folders that this server may read. Add the video "
                    "again from where it lies now."
                ) from None
            raise VideoError(unreadable(self.path, error)) from None


_PUT_BACK = "Put it back as it was, or add it as another video."


def stamp_now(path: Path) -> Stamp | None:
    """How the file of a name stands; None: there is none. It is not opened."""
    try:
        found = path.stat()
    except OSError:
        return None
    return stamp_of(found) if stat.S_ISREG(found.st_mode) else None


def library_file(settings: Settings, video: Video) -> CheckedFile:
    """The file of a video of the library; one that lies in shared files is fetched first.

    Raises:
        FilesAwayError, Busy, StorageError: as of :meth:`app.files.shared.SharedFiles.fetch`.
    """
    home = Path(os.path.realpath(settings.home))
    path, stamp = Path(video.path), None if video.stamp is None else tuple(video.stamp)
    files = shared_files(settings)
    if files is not None and video.place == files.id:
        name = f"videos/{video.id}"
        if stamp is not None and stamp_now(path) == stamp:
            files.used(name)  # the very file that was added here
        else:
            path = files.fetch(name)
            stamp = files.stamp(name)
    return CheckedFile(path, [*roots_of(settings), home], video.id, stamp)  # type: ignore[arg-type]


def own_file(path: Path) -> CheckedFile:
    """A video that the server itself has written, or that came with it; its folder is reached by its name."""
    return CheckedFile(path, [Path(os.path.realpath(path.parent))])
