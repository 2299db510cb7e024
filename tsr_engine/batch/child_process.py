"""Supplies functions for processes of the engine on any machine."""

from __future__ import annotations

import json
import os
import resource
import sys
import threading
import time
from collections.abc import Mapping

from tsr_engine.errors import ModelError
from tsr_engine.json_shapes import JsonObject


def child_environment() -> dict[str, str]:
    """The environment of a process of the engine: the paths of this one, and one thread for each library."""
    threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    return {**os.environ, **threads, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}


def require_models(wanted: Mapping[str, str], found: Mapping[str, str]) -> None:
    """Refuse models that differ from those of the task.

    Args:
        wanted: component -> SHA-256.
        found: component -> SHA-256 of the models on this machine.

    Raises:
        ModelError: they differ.
    """
    different = [name for name, digest in wanted.items() if found.get(name) != digest]
    if different:
        raise ModelError(
            f"{os.uname().nodename} has another {', '.join(different)} than this work was started with. "
            "Give every machine the same models."
        )


def limit_memory(megabytes: int) -> None:
    """Limit the address space of this process, MiB; 0: no limit."""
    if megabytes:
        size = megabytes * 2**20
        resource.setrlimit(resource.RLIMIT_AS, (size, resource.getrlimit(resource.RLIMIT_AS)[1]))


def exit_with_parent(parent: int) -> None:
    """End this process soon after its parent: its output has no reader, and another process may get the drive."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    threading.Thread(target=watch, name="tsr-parent", daemon=True).start()


def send_message(message: JsonObject) -> None:
    """Write one line of JSON to stdout for the parent process."""
    sys.stdout.write(json.dumps(message, allow_nan=False) + "\n")
    sys.stdout.flush()


def send_note(note: str) -> bool:
    """Write what the process does before it tracks, or an empty text when that is over; returns True: it is written."""
    send_message({"note": note})
    return True
