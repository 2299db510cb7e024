"""The attack at length: ``python -m tests.attack.campaign --kills 200 --hours 1 --seed 1``, or ``make attack``.

A separate server is killed while many clients edit on SQLite and PostgreSQL. It imports randomly damaged files and
files that ask for all memory, cannot grow its files, and meets a read-only file system and jumping clocks. Damaged
models are loaded at last. A stage says if something is not installed or needs root. Every stage prints its counts. The
first broken promise ends the campaign with its seed and exit code 1.
"""

from __future__ import annotations

import argparse
import math
import random
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from tests.app.databases import Cluster, new_database, running_cluster
from tests.attack.campaign_stages import (
    Scale,
    edit_tracks,
    exhaust_memory,
    import_damaged_files,
    jump_clock,
    kill_server,
    limit_file_sizes,
    make_disk_read_only,
)
from tests.attack.concurrent_editors import BrokenGuaranteeError, TrackedLibrary
from tests.attack.damage import small_files
from tests.attack.damaged_models import load_damaged
from tests.attack.libraries import UploadFiles, sample_library, toy_library


def campaign(folder: Path, seed: int, scale: Scale, stages: Sequence[str] = (), real: bool = True) -> dict[str, str]:
    """Run the stages, each on its own data folder.

    Args:
        folder: empty.
        seed: of all random choices.
        scale: size of the campaign.
        stages: names of stages; none: all.
        real: use a sample drive tracked by the engine; else a toy drive, within seconds.

    Raises:
        BrokenGuaranteeError: the first promise that does not hold.
    """
    first, files = (
        sample_library(folder / "first") if real else (toy_library(folder / "first"), UploadFiles(small_files(), {}))
    )
    do: dict[str, Callable[[TrackedLibrary, random.Random], str]] = {
        "kills": lambda library, rng: kill_server(library, rng, scale),
        "kills on PostgreSQL": lambda _, rng: on_postgresql(
            folder / "1", lambda library, cluster: kill_server(library, rng, scale, cluster)
        ),
        "edits": lambda library, rng: edit_tracks(library, rng, scale),
        "edits on PostgreSQL": lambda _, rng: on_postgresql(
            folder / "2", lambda library, _: edit_tracks(library, rng, scale)
        ),
        "damaged files": lambda library, rng: import_damaged_files(library, rng, scale, files),
        "memory": exhaust_memory,
        "disk": lambda library, rng: limit_file_sizes(library, rng, scale.people),
        "read-only disk": lambda library, rng: make_disk_read_only(library, rng, scale.people),
        "clock": lambda library, rng: jump_clock(library, rng, scale),
        "models": lambda library, rng: load_damaged(library.home, rng, scale.models),
    }
    results = {}
    for name in stages or do:
        library = replace(first, home=folder / name.replace(" ", "-"))
        shutil.copytree(first.home, library.home)
        began = time.monotonic()
        try:
            results[name] = do[name](library, random.Random(f"{seed} {name}"))
        except BrokenGuaranteeError as error:
            raise BrokenGuaranteeError(f"{name}, seed {seed}: {error}") from error
        print(f"{name} ({time.monotonic() - began:.0f} s): {results[name]}", flush=True)
    return results


def on_postgresql(folder: Path, stage: Callable[[TrackedLibrary, Cluster], str]) -> str:
    """Run a stage with a separate PostgreSQL."""
    try:
        with running_cluster() as cluster:
            return stage(sample_library(folder, new_database(cluster.url))[0], cluster)
    except pytest.skip.Exception as without:
        return f"left out: {without}"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--kills", type=int, default=200, help="how often the server is killed, on each database")
    parser.add_argument("--minutes", type=float, default=math.inf, help="of kills at most, on each database")
    parser.add_argument("--hours", type=float, default=1.0, help="how long damaged files are imported")
    parser.add_argument("--clients", type=int, default=20, help="people who edit meanwhile, three on each track")
    parser.add_argument("--seed", type=int, default=1, help="of everything that is random")
    parser.add_argument("--only", action="append", default=[], metavar="STAGE", help="a stage; repeatable")
    asked = parser.parse_args()
    scale = Scale(asked.kills, asked.hours * 3600, asked.clients, minutes=asked.minutes)
    with tempfile.TemporaryDirectory(prefix="tsr-attack-") as folder:
        try:
            campaign(Path(folder), asked.seed, scale, asked.only)
        except BrokenGuaranteeError as error:
            print(f"BROKEN: {error}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
