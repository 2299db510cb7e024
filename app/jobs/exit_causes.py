"""Explains why a worker ended: a file that crashes decoders, or a machine without memory."""

from __future__ import annotations

import os
import re
import signal
from pathlib import Path
from typing import Final, Literal, NoReturn

ExitCause = Literal["crashed", "starved", "killed"]
"""``crashed``: by itself on its file; ``starved``: out of memory; ``killed``: with its server, or from outside."""
TERMINATED: Final = 128 + signal.SIGTERM
"""Exit code of a worker that was asked to leave and did not finish in time."""
_CRASHED: Final = 70
"""Exit code of a worker whose run has crashed elsewhere; never that of Ray, 1."""
_CLUSTER_LOST: Final = 1
"""Exit code with which Ray ends a process whose cluster has not answered for a minute."""
_EXTERNAL_EXITS: Final = {0, TERMINATED, -signal.SIGTERM, -signal.SIGINT, -signal.SIGHUP, -signal.SIGKILL}
CGROUPS = Path("/sys/fs/cgroup")
PROC = Path("/proc")


def exit_cause(code: int, out_of_memory: bool, on_cluster: bool = False) -> ExitCause:
    """Determine the cause from an exit code.

    Args:
        code: from ``subprocess``; below 0: a signal.
        out_of_memory: whether the kernel has killed processes for lack of memory meanwhile.
        on_cluster: whether the process only waits for a run on a Ray cluster.
    """
    if code == -signal.SIGKILL and out_of_memory:
        return "starved"
    if on_cluster and code == _CLUSTER_LOST:
        return "killed"
    return "killed" if code in _EXTERNAL_EXITS else "crashed"


def exit_with_cause(cause: Literal["crashed", "killed"]) -> NoReturn:
    """End this worker with a cause, because the process that did its work elsewhere died of it."""
    os._exit(TERMINATED if cause == "killed" else _CRASHED)


def count_oom_kills() -> int:
    """Number of processes that the kernel has killed for lack of memory: in our control group, or on the machine."""
    for file in _counter_files():
        try:
            match = re.search(r"^oom_kill (\d+)$", file.read_text(encoding="ascii"), flags=re.MULTILINE)
        except OSError:
            continue
        if match is not None:
            return int(match[1])
    return 0


def _counter_files() -> list[Path]:
    try:
        groups = (PROC / "self" / "cgroup").read_text(encoding="utf-8")
    except OSError:
        groups = ""
    files = []
    for number, controllers, path in re.findall(r"^(\d+):([^:]*):/(.*)$", groups, flags=re.MULTILINE):
        if number == "0":
            files += [CGROUPS / path / "memory.events", CGROUPS / "memory.events"]
        elif "memory" in controllers.split(","):
            files += [CGROUPS / "memory" / path / "memory.oom_control", CGROUPS / "memory" / "memory.oom_control"]
    return [*files, PROC / "vmstat"]
