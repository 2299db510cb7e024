"""Memory and processor time of processes, read from Linux's ``/proc``."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable
from pathlib import Path

_TICKS = os.sysconf("SC_CLK_TCK")


def memory() -> dict[str, float]:
    """Resident memory of this process now and at its peak, MB (10^6 bytes).

    The peak of ``getrusage`` would include that of its parent.
    """
    found = _memory(os.getpid())
    return {"rss_mb": found["VmRSS"] * 1024 / 1e6, "peak_mb": found["VmHWM"] * 1024 / 1e6}


def resident_mb(pids: Iterable[int]) -> float:
    """Resident memory of processes, in MB of 2^20 bytes.

    This is an upper bound, since memory that several processes share counts for each.
    """
    total = 0
    for pid in pids:
        with contextlib.suppress(OSError):  # it has ended meanwhile
            total += _memory(pid).get("VmRSS", 0)
    return total / 1024


def processor_seconds(pid: int) -> float:
    """Seconds of processor time that a process has used."""
    fields = _stat_fields(pid)
    return (int(fields[11]) + int(fields[12])) / _TICKS


def child_processes(pid: int) -> list[int]:
    """All direct and indirect child processes of a process."""
    children: dict[int, list[int]] = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            children.setdefault(int(_stat_fields(int(folder.name))[1]), []).append(int(folder.name))
    found = list(children.get(pid, ()))
    for child in found:
        found += children.get(child, ())
    return found


def _memory(pid: int) -> dict[str, int]:
    """Values of the process's memory by their name in Linux, KiB."""
    lines = Path(f"/proc/{pid}/status").read_text(encoding="utf-8").splitlines()
    return {line.split(":")[0]: int(line.split()[1]) for line in lines if line.startswith(("VmRSS", "VmHWM"))}


def _stat_fields(pid: int) -> list[str]:
    """The fields from the state on; they follow the last bracket, since the name in brackets may hold brackets."""
    return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
