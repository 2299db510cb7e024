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
from app.videos.paths import root_of
from app.videos.safe_open import LINK_ERRORS, open_inside, resolve_links
from sample_videos import SHIPPED
from tsr_engine.errors import VideoError
from tsr_engine.io.opened_file import OpenedFile, Stamp, stamp_of, unreadable_message


class ChangedError(VideoError):
    """The file's bytes do not match the hash that identifies the video."""


def allowed_roots(settings: Settings) -> list[Path]:
    """Return the folders from which videos may be added, links resolved; the bundled drives' is always included."""
    return [*settings.roots, Path(os.path.realpath(SHIPPED[0].video.parent))]


class CheckedFile:
    """A file that is checked each time it is opened; thread-safe, and a ``VideoSource`` for the engine.

    Attributes:
        path: its path.
        roots: folders in which links are followed.
        digest: SHA-256 that its bytes must have; None: only the server writes the file.
        stamp: its state when its bytes were last compared; None: never.
    """

    def __init__(
        self, path: Path, roots: Sequence[Path], digest: str | None = None, stamp: Stamp | None = None
    ) -> None:
        """Name the file; it is not opened yet.

        Args:
            path: absolute. A path outside the roots was resolved when it was added under other roots, so no part of it
                may be a link now.
            roots: folders, links resolved, in which links are followed if they stay inside.
            digest: SHA-256 that its bytes must have; None: only the server writes the file.
            stamp: state of the file when its bytes were last compared.
        """
        self.path = path
        self.stamp = stamp
        self.roots = roots
        self.digest = digest

    def __str__(self) -> str:
        return str(self.path)

    @property
    def exists(self) -> bool:
        """Whether a file with that name exists, or may exist in a folder that cannot be searched.

        It may be another file than the video.
        """
        try:
            return self.path.is_file()
        except OSError:  # opening it says why
            return True

    def open(self) -> OpenedFile:
        """Open the file; if it was touched since the last comparison, its bytes are read and compared.

        Raises:
            ChangedError: it has other bytes.
            VideoError: it is missing, cannot be read, or its path contains a link.
        """
        file = self._open()
        try:
            before = file.stamp
            if self.digest is not None and before != self.stamp:
                if file.sha256() != self.digest:
                    raise ChangedError(f"{self.path} has changed since it was added. {_REMEDY}")
                if file.stamp != before:
                    raise ChangedError(f"{self.path} was written to while it was read. {_REMEDY}")
                self.stamp = before
        except BaseException:
            file.close()
            raise
        return file

    def _open(self) -> OpenedFile:
        real = resolve_links(self.path)
        root = root_of(real, self.roots)
        path = self.path if root is None else real
        try:
            return OpenedFile(open_inside(root or Path("/"), path), self.path)
        except OSError as error:
            if error.errno in LINK_ERRORS:
                raise VideoError(
                    f"{self.path} leads through a link out of the folders that this server may read. Add the video "
                    "again from its new path."
                ) from None
            raise VideoError(unreadable_message(self.path, error)) from None


_REMEDY = "Restore it, or add it as another video."


def current_stamp(path: Path) -> Stamp | None:
    """Return the state of a file by its name, without opening it; None: there is none."""
    try:
        status = path.stat()
    except OSError:
        return None
    return stamp_of(status) if stat.S_ISREG(status.st_mode) else None


def library_file(settings: Settings, video: Video) -> CheckedFile:
    """Return the file of a video of the library; one in shared files is fetched first.

    Raises:
        SharedFilesError, Busy, StorageError: as for :meth:`app.files.shared.SharedFiles.fetch`.
    """
    home = Path(os.path.realpath(settings.home))
    path, stamp = Path(video.path), None if video.stamp is None else tuple(video.stamp)
    files = shared_files(settings)
    if files is not None and video.place == files.id:
        name = f"videos/{video.id}"
        if stamp is not None and current_stamp(path) == stamp:
            files.mark_used(name)  # the file that was added here
        else:
            path = files.fetch(name)
            stamp = files.stamp(name)
    return CheckedFile(path, [*allowed_roots(settings), home], video.id, stamp)  # type: ignore[arg-type]


def trusted_file(path: Path) -> CheckedFile:
    """Return a video file that the server has written or that ships with it; links in its path are followed."""
    return CheckedFile(path, [Path(os.path.realpath(path.parent))])
