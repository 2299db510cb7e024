"""A disk that fails on demand: an ext4 file system in a file, which the kernel makes read-only after an error."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.waiting import wait_until

__all__ = ["DiskUnavailableError", "FailingDisk", "failing_disk"]

_SIZE = 256 << 20


class DiskUnavailableError(Exception):
    """This machine cannot provide such a disk."""


class FailingDisk:
    """A mounted file system.

    Attributes:
        mount_point: where it is mounted.
    """

    def __init__(self, image: Path, mount_point: Path) -> None:
        self._image = image
        self.mount_point = mount_point
        mount_point.mkdir()
        self._mount()

    @property
    def trigger(self) -> Path:
        """Write where the kernel finds an error; not every kernel has it."""
        command = ["findmnt", "-no", "SOURCE", self.mount_point]
        device = subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
        return Path("/sys/fs/ext4") / Path(device).name / "trigger_fs_error"

    def fail(self) -> None:
        """Make the disk fail: from now on no write succeeds."""
        self.trigger.write_text("attack")

    def repair(self) -> None:
        """Repair it and mount it again; no file may be open on it."""
        self.unmount()
        # 1: errors were corrected
        if subprocess.run(["e2fsck", "-fp", self._image], capture_output=True).returncode > 1:
            raise RuntimeError(f"{self._image} cannot be repaired")
        self._mount()

    def unmount(self) -> None:
        """Unmount it and release its device. Children of a killed server may end a moment later, so retry."""
        wait_until(lambda: subprocess.run(["umount", self.mount_point], capture_output=True).returncode == 0, 30)

    def _mount(self) -> None:
        options = "loop,errors=remount-ro"
        subprocess.run(["mount", "-o", options, self._image, self.mount_point], check=True, capture_output=True)


@contextmanager
def failing_disk(folder: Path, content: Path) -> Iterator[FailingDisk]:
    """A disk with a copy of a folder on it.

    Args:
        folder: for its image.
        content: the folder that is copied.

    Raises:
        DiskUnavailableError: this process may not mount, or the tools are missing.
    """
    if os.geteuid() != 0:
        raise DiskUnavailableError("only root can mount a disk")
    image = folder / "disk"
    try:
        with image.open("wb") as file:
            file.truncate(_SIZE)
        subprocess.run(["mkfs.ext4", "-q", image], check=True, capture_output=True)
        disk = FailingDisk(image, folder / "mounted")
    except (OSError, subprocess.CalledProcessError) as error:
        raise DiskUnavailableError(f"no disk can be made here ({error})") from None
    try:
        if not disk.trigger.exists():
            raise DiskUnavailableError("this kernel lets no disk fail")
        shutil.copytree(content, disk.mount_point / content.name)
        os.sync()  # unsynced data may be lost
        yield disk
    finally:
        disk.unmount()
