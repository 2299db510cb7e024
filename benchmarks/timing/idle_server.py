"""Measures the processor time of a server without work, and of its standby worker while a page is open.

Run it on a quiet machine with compiled kernels::

python -m benchmarks.timing.idle_server [--seconds 20]
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path
from typing import Final

from benchmarks.timing.processes import processor_seconds
from benchmarks.timing.waiting import simulated_page
from tests.attack.server_process import children, command_line
from tests.e2e.live_server import LiveServer

_READY: Final = 60.0
"""Seconds until the standby worker has loaded everything, with compiled kernels."""


def core_share(process: int, seconds: float) -> float:
    """Share of one core that a process uses, %, over some seconds."""
    before = processor_seconds(process)
    time.sleep(seconds)
    return round(100 * (processor_seconds(process) - before) / seconds, 2)


def measure(seconds: float) -> dict[str, float]:
    """Shares of one core, %: the server without a page, with one, and its standby worker."""
    with tempfile.TemporaryDirectory() as home, LiveServer(Path(home), sample=False) as server:
        time.sleep(5)
        found = {"server without a page": core_share(server.pid, seconds)}
        with simulated_page(server):
            time.sleep(_READY)
            found["server with a page"] = core_share(server.pid, seconds)
            (worker,) = (child for child in children(server.pid) if b"app.worker" in command_line(child))
            found["standby worker"] = core_share(worker, seconds)
    return found


def main() -> None:
    """Print the shares as JSON."""
    parser = argparse.ArgumentParser(description="Measure a server without work.")
    parser.add_argument("--seconds", type=float, default=20.0, help="length of each measurement, s")
    print(json.dumps(measure(parser.parse_args().seconds), indent=1))


if __name__ == "__main__":
    main()
