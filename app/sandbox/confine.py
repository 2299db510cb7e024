"""Permanently limits this process: memory, computing, files, network, other programs.

A sandbox (``confine``) only reads bytes from outside. A worker (``restrict_process``) decodes them too, but stores its
results: it keeps the data folder and, if it needs them, connections.

Limits and the signal at the parent's death work on every Linux. Landlock (Linux 5.13; connections since 6.7) and
seccomp (x86-64 and AArch64) are added if the kernel has them. No well-maintained Python package exists for either, and
each is three system calls.
"""

from __future__ import annotations

import ctypes
import errno
import os
import platform
import resource
import signal
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from app.sandbox.limits import Limits

_SET_PDEATHSIG: Final = 1
_SET_NO_NEW_PRIVS: Final = 38
_FILTER, _ALL_THREADS = 1, 1

_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446
"""Landlock's system calls have these numbers on every architecture."""
_WRITE_FILE: Final = 1 << 1
_WRITE_RIGHTS: Final = {1: _WRITE_FILE | 0x1FF0, 2: 1 << 13, 3: 1 << 14}
"""Rights that change the file system, by the version of Landlock that knows them."""
_CONNECT_RIGHTS: Final = 0b11
_SCOPES: Final = 0b11
"""Scopes that shut out abstract sockets and signals to processes outside."""

_SECCOMP: Final = {"x86_64": (0xC000003E, 317), "aarch64": (0xC00000B7, 277)}
"""Architecture -> its audit number, and the number of the system call ``seccomp``."""
_CONNECTION_CALLS: Final = {"x86_64": (41, 42, 43, 49, 50, 288), "aarch64": (198, 203, 202, 200, 201, 242)}
"""socket, connect, accept, bind, listen, accept4."""
_ALWAYS_DENIED: Final = {
    "x86_64": (59, 101, 250, 298, 310, 311, 321, 322, 323, 425, 434),
    "aarch64": (221, 117, 219, 241, 270, 271, 280, 281, 282, 425, 434),
}
"""Calls that nothing here needs: execve, ptrace, keyctl, perf_event_open, process_vm_readv, process_vm_writev, bpf,
execveat, userfaultfd, io_uring_setup, pidfd_open.
"""
_X32: Final = 0x40000000
_ALLOW, _DENY = 0x7FFF0000, 0x00050000 | errno.EPERM

_libc = ctypes.CDLL(None, use_errno=True)


def die_with_parent(parent: int, sign: signal.Signals = signal.SIGKILL) -> bool:
    """Send this process a signal when the thread that started it ends.

    Args:
        parent: id of the process that started this one.
        sign: the signal.

    Returns:
        False if the parent has ended already.
    """
    _libc.prctl(_SET_PDEATHSIG, sign, 0, 0, 0)
    return os.getppid() == parent


def confine(limits: Limits) -> None:
    """Apply the limits to this process, which must have one thread."""
    os.nice(limits.nice)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    max_bytes = _address_space() + limits.memory_mb * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (max_bytes, max_bytes))
    if limits.computing:
        used = int(sum(resource.getrusage(resource.RUSAGE_SELF)[:2]))
        resource.setrlimit(resource.RLIMIT_CPU, (used + limits.computing, used + limits.computing))
    max_file_bytes = limits.file_mb * 2**20 if limits.writable or limits.network else 0
    resource.setrlimit(resource.RLIMIT_FSIZE, (max_file_bytes, max_file_bytes))
    restrict_process(None if limits.network else limits.writable, network=limits.network)


def restrict_process(writable: Sequence[Path] | None, *, network: bool = False) -> None:
    """Keep this process from starting programs and from reading other processes' memory; best called with one thread.

    Args:
        writable: folders below which it may write; None: no further limit.
        network: allow new connections.
    """
    _libc.prctl(_SET_NO_NEW_PRIVS, 1, 0, 0, 0)
    if writable is not None:
        _landlock(writable)
    _seccomp(network)


def _address_space() -> int:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    return pages * resource.getpagesize()


def _landlock(writable: Sequence[Path]) -> None:
    """Allow writes only below some folders and no connections, as far as the kernel supports it."""
    version = _libc.syscall(_CREATE_RULESET, None, ctypes.c_size_t(0), ctypes.c_uint32(1))
    if version < 1:
        return
    rights = sum(added for since, added in _WRITE_RIGHTS.items() if since <= version)
    ruleset = struct.pack("QQQ", rights, _CONNECT_RIGHTS if version >= 4 else 0, _SCOPES if version >= 6 else 0)
    size = 24 if version >= 6 else 16 if version >= 4 else 8
    rules = _libc.syscall(_CREATE_RULESET, ruleset, ctypes.c_size_t(size), ctypes.c_uint32(0))
    if rules < 0:
        return
    for path, allowed in [*((folder, rights) for folder in writable), (Path(os.devnull), _WRITE_FILE)]:
        parent = os.open(path, os.O_PATH | os.O_CLOEXEC)
        rule = struct.pack("=Qi", allowed, parent)
        _libc.syscall(_ADD_RULE, rules, ctypes.c_int(1), rule, ctypes.c_uint32(0))
        os.close(parent)
    _libc.syscall(_RESTRICT_SELF, rules, ctypes.c_uint32(0))
    os.close(rules)


def _seccomp(network: bool) -> None:
    """Deny all threads other programs and other processes' memory, and connections unless allowed."""
    machine = platform.machine()
    if machine not in _SECCOMP:
        return
    architecture, call = _SECCOMP[machine]
    denied = _ALWAYS_DENIED[machine] if network else (*_ALWAYS_DENIED[machine], *_CONNECTION_CALLS[machine])
    load, equal, at_least, ret = 0x20, 0x15, 0x35, 0x06
    count = len(denied)
    instructions = [
        (load, 0, 0, 4),  # the architecture
        (equal, 0, count + 3, architecture),  # another architecture: denied
        (load, 0, 0, 0),  # the number of the call
        (at_least, count + 1, 0, _X32),
        *((equal, count - at, 0, number) for at, number in enumerate(denied)),
        (ret, 0, 0, _ALLOW),
        (ret, 0, 0, _DENY),
    ]
    code = ctypes.create_string_buffer(b"".join(struct.pack("HBBI", *instruction) for instruction in instructions))
    program = struct.pack("HP", len(instructions), ctypes.addressof(code))
    _libc.syscall(call, _FILTER, _ALL_THREADS, program)
