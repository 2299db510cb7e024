"""Cost of imports for the server: ``python -m tests.attack.measure`` prints a table of time, memory and waiting.

Hostile and honest files are imported one after another while a client sends small requests. Rows hold the import's
status and seconds, the server's peak memory, and the times of the other answers. The first row is measured without an
import. ``TSR_TREE`` names the folder of another version to measure.
"""

from __future__ import annotations

import argparse
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from tests import toy_pipeline
from tests.attack.damage import small_files, zipped
from tests.attack.many_tracks import cvat_archive, mot_archive
from tests.attack.server_process import ServerProcess, start_server
from tests.attack.test_from_outside import add_video, environment, start_run, wait_for_run

REPEATS = 15
"""How often each small file is imported."""
IDLE_S = 10.0
"""Seconds without an import."""


def hostile() -> dict[str, bytes]:
    """Archives that unpack to large contents."""
    zeros, spaces = bytes(300 << 20), b"<annotations>" + b" " * (200 << 20) + b"</annotations>"
    return {
        "100,000 tracks": mot_archive(100_000),
        "20,000 tracks of 60 boxes": mot_archive(20_000, 60),
        "19,000 tracks between key frames": cvat_archive(19_000),
        "15,000 tracks, let in": mot_archive(15_000),
        "19,000 tracks of 50 boxes, let in": mot_archive(19_000, 50),
        "300 MB of zeros": zipped({"annotations.json": zeros}),
        "200 MB of spaces": zipped({"annotations.xml": spaces}),
        "50 million brackets": zipped({"annotations.json": b"[" * (50 << 20)}),
    }


def row(server: ServerProcess, label: str, kind: str, do: Callable[[], int]) -> None:
    """Measure the server during an action and print a row; the action returns a status."""
    server.waits.clear()
    server.memory = 0
    began = time.monotonic()
    with server.monitored():
        status = do()
    waits = [1000 * wait for wait in server.waits]
    cells = (
        *(label, kind, status or "", f"{time.monotonic() - began:.1f}", server.memory),
        f"{statistics.quantiles(waits, n=20)[18]:.0f}" if len(waits) > 1 else f"{waits[0]:.0f}",
        *(f"{max(waits):.0f}", sum(wait > 500 for wait in waits)),
    )
    print(f"| {' | '.join(str(cell) for cell in cells)} |", flush=True)


def idle() -> int:
    time.sleep(IDLE_S)
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--small", action="store_true", help="small files only")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tsr-measure-") as name:
        folder = Path(name)
        drive = toy_pipeline.write_drive(folder / "drive.mp4", 75)
        with start_server(folder / "home", environment(folder)) as server:
            video = add_video(server, drive)
            run = start_run(server, video)
            wait_for_run(server, run)
            print(f"server at rest: {server.resident()} MiB")
            for label, content in small_files().items():
                took = []
                for number in range(REPEATS):
                    began = time.monotonic()
                    path = f"/api/videos/{video}/imports?as=truth&file={label}&name=small{number}"
                    status, _ = server.request(path, content)
                    took.append(time.monotonic() - began)
                print(
                    f"small {label}: {status}, median {statistics.median(took) * 1000:.0f} ms of {REPEATS}", flush=True
                )
            print("| file | as | status | s | server, MiB | other answers: 95 % within, ms | slowest | over 500 ms |")
            print("|---|---|---|---|---|---|---|---|")
            row(server, "nothing", "", idle)
            for label, content in ({} if asked.small else hostile()).items():
                for kind in ("truth", "annotation", "run"):
                    path = f"/api/videos/{video}/imports?as={kind}&file=a.zip&name=a&run={run}"
                    row(server, label, kind, lambda path=path, content=content: server.request(path, content, 900)[0])
            print(
                f"{os.getloadavg()[0]:.0f} processes at once, {os.getloadavg()[2]:.0f} over the last quarter of an hour"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
