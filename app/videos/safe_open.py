"""Opens files inside a folder without following links, so that the path cannot be redirected.

A path is first resolved and checked as text. If a link is then placed in the path, or replaces a folder, the open is
refused, because the kernel checks each part.
"""

from __future__ import annotations

import ctypes
import errno
import os
import stat
import struct
from pathlib import Path
from typing import Final

LINK_ERRORS: Final = (errno.ELOOP, errno.EXDEV)
"""Errors of the kernel for a path that goes through a link, or out of the folder."""
_OPENAT2: Final = 437
_NO_MAGICLINKS, _NO_SYMLINKS, _BENEATH = 0x02, 0x04, 0x08
_UNAVAILABLE: Final = (errno.ENOSYS, errno.EPERM)
"""Errors if the kernel does not have the call, or a sandbox does not allow it."""


def resolve_links(path: Path) -> Path:
    """Resolve the links of a path.

    A path that changes meanwhile may not be resolvable. Then it is returned unchanged: ``open_inside`` checks each
    part again.
    """
    try:
        return Path(os.path.realpath(path))
    except OSError:
        return path


def open_inside(folder: Path, path: Path, flags: int = os.O_RDONLY) -> int:
    """Open a file or folder by a path without links.

    Args:
        folder: trusted, so links in its own path are followed: the server's owner has named it.
        path: a path in it; absolute, and without ``..``.
        flags: further flags.

    Returns:
        The descriptor; not inherited.

    Raises:
        OSError: it does not exist or cannot be read; one of ``LINK_ERRORS``: a part of the path is a link.
    """
    parts = path.relative_to(folder).parts or (".",)
    # non-blocking, because opening a pipe without a writer would wait
    flags |= os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_NOCTTY
    root_fd = os.open(folder, os.O_PATH | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        try:
            return openat2(root_fd, str(Path(*parts)), flags)
        except OSError as error:
            if error.errno not in _UNAVAILABLE:
                raise
        return _walk(root_fd, parts, flags)
    finally:
        os.close(root_fd)


def openat2(root_fd: int, path: str, flags: int) -> int:
    """Call ``openat2(2)``: open a path below a folder without following symbolic links.

    Raises:
        OSError: the kernel refuses, or does not have the call.
    """
    how = struct.pack("=QQQ", flags, 0, _NO_MAGICLINKS | _NO_SYMLINKS | _BENEATH)
    libc = ctypes.CDLL(None, use_errno=True)
    arguments = ctypes.c_int(root_fd), os.fsencode(path), how, ctypes.c_size_t(len(how))
    descriptor = libc.syscall(ctypes.c_long(_OPENAT2), *arguments)
    if descriptor < 0:
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code), path)
    return int(descriptor)


def _walk(root_fd: int, parts: tuple[str, ...], flags: int) -> int:
    """Open the path part by part, for kernels before 5.6."""
    current = os.dup(root_fd)
    try:
        for part in parts[:-1]:
            following = os.open(part, os.O_PATH | os.O_NOFOLLOW | os.O_CLOEXEC, dir_fd=current)
            os.close(current)
            current = following
            if stat.S_ISLNK(os.fstat(current).st_mode):
                raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), part)
        return os.open(parts[-1], flags, dir_fd=current)
    finally:
        os.close(current)
