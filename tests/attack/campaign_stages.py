"""The stages of the campaign. Each returns its counts in a sentence, or raises at the first broken promise."""

from __future__ import annotations

import math
import os
import random
import resource
import signal
import statistics
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

from tests.app.databases import Cluster
from tests.attack.concurrent_editors import (
    MAX_PAUSE_S,
    AnswerLog,
    BrokenGuaranteeError,
    TrackedLibrary,
    check_log,
    clients,
)
from tests.attack.damage import damaged, damaged_archive, fix_manifest, zipped
from tests.attack.failing_disk import DiskUnavailableError, failing_disk
from tests.attack.libraries import UploadFiles
from tests.attack.server_process import ServerProcess, start_server
from tests.waiting import time_limit, wait_until

MAX_MEMORY_MB = 600
"""Memory of the server, MiB."""
MAX_IMPORT_S = time_limit(15)
"""Seconds that an import of a small damaged file may take."""
FAKETIME = ("/usr/lib/*/faketime/libfaketime.so.1", "/usr/lib/faketime/libfaketime.so.1")


@dataclass(frozen=True)
class Scale:
    """Size of the campaign.

    Attributes:
        kills: kills of the server on each database.
        minutes: at most, of kills on each database.
        seconds: duration of imports of damaged files.
        people: concurrent clients.
        min_imports: damaged files at least.
        jumps: jumps of the clock.
        models: damaged models.
    """

    kills: int
    seconds: float
    people: int
    min_imports: int = 50
    jumps: int = 12
    models: int = 400
    minutes: float = math.inf


def kill_server(library: TrackedLibrary, rng: random.Random, scale: Scale, cluster: Cluster | None = None) -> str:
    """Kill the server repeatedly while people edit; with a cluster, sometimes the database too."""
    log, current, done, outages = AnswerLog(), list[ServerProcess](), 0, 0
    end = time.monotonic() + 60 * scale.minutes
    with ExitStack() as people:
        while done < scale.kills and time.monotonic() < end:
            with start_server(library.home, library.environment, forked=True) as server:
                current[:] = [server]
                if not done:
                    wait_until(lambda: current[0].request(f"/api/runs/{library.run}/tracks")[0] == 200)
                    people.enter_context(clients(library, lambda: current[0], log, scale.people, rng))
                done += 1
                wait_for_edits(log, rng.randint(0, 2 * scale.people))
                time.sleep(rng.uniform(0.0, 0.2))
                if cluster is not None and rng.random() < 0.1:
                    cluster.stop(rng.choice(("fast", "immediate")))
                    cluster.start()
                    outages += 1
                    wait_for_edits(log, rng.randint(0, 2 * scale.people))
    stored = check_log(library, log)
    restarts = f", {outages} restarts of the database" if cluster is not None else ""
    return (
        f"{done} kills{restarts}, {scale.people} clients on {len(library.tracks)} tracks: "
        f"{len(log.acknowledged)} acknowledged, {stored} stored, none lost, none twice; {dict(log.refused)}"
    )


def edit_tracks(library: TrackedLibrary, rng: random.Random, scale: Scale) -> str:
    """Let people edit for a while, at one edit a second or as fast as possible, and measure the time of an edit."""
    return "; ".join(edit_at_pace(library, rng, scale, max_pause_s) for max_pause_s in (2.0, MAX_PAUSE_S))


def edit_at_pace(library: TrackedLibrary, rng: random.Random, scale: Scale, max_pause_s: float) -> str:
    """Let people edit for a while, each with a minimum time between two edits."""
    log, began = AnswerLog(), time.monotonic()
    with start_server(library.home, library.environment) as server:
        wait_until(lambda: server.request(f"/api/runs/{library.run}/tracks")[0] == 200)
        began = time.monotonic()
        with clients(library, lambda: server, log, scale.people, rng, max_pause_s):
            wait_for_edits(log, 30 * scale.people)
        took = time.monotonic() - began
    check_log(library, log)

    def describe(waits: Sequence[float]) -> str:
        twentieths = [1000 * wait for wait in statistics.quantiles(waits, n=20)]
        return f"median {twentieths[9]:.0f} ms, 95 % within {twentieths[18]:.0f} ms, slowest {1000 * max(waits):.0f} ms"

    return (
        f"{len(log.waits)} edits by {scale.people} clients in {took:.0f} s: {describe(log.waits)}; in the server: "
        f"{describe(log.handled)}; {os.getloadavg()[0]:.1f} processes at once"
    )


def import_damaged_files(library: TrackedLibrary, rng: random.Random, scale: Scale, files: UploadFiles) -> str:
    """Import randomly damaged files."""
    statuses: Counter[int] = Counter()
    slowest, done = (0.0, ""), 0
    with start_server(library.home, library.environment) as server, server.monitored():
        end = time.monotonic() + scale.seconds
        while time.monotonic() < end or done < scale.min_imports:
            if files.bundles and rng.random() < 0.1:
                name = rng.choice(sorted(files.bundles))
                path, content = "/api/bundles", damaged_archive(files.bundles[name], rng, fix_manifest)
            else:
                name = rng.choice(sorted(files.annotations))
                kind = rng.choice(("truth", "annotation", "run"))
                path = f"/api/videos/{library.video}/imports?as={kind}&file={name}&name=fuzzed&run={library.run}"
                damage = damaged_archive if name.endswith(".zip") else damaged
                content = damage(files.annotations[name], rng)
            began = time.monotonic()
            status, answer = server.request(path, content)
            slowest = max(slowest, (time.monotonic() - began, name))
            statuses[status] += 1
            if status >= 500:
                raise BrokenGuaranteeError(f"import {done}, {name}, was answered with {status}: {answer}")
            if slowest[0] > MAX_IMPORT_S:
                raise BrokenGuaranteeError(f"import {done}, {name}, took {slowest[0]:.0f} s")
            done += 1
    return f"{done} damaged files: {dict(statuses)}, slowest {slowest[0]:.1f} s ({slowest[1]}), {server_load(server)}"


def server_load(server: ServerProcess) -> str:
    """Memory and time that a watched server needed.

    Raises:
        BrokenGuaranteeError: too much memory.
    """
    if server.memory > MAX_MEMORY_MB:
        raise BrokenGuaranteeError(f"the server held {server.memory} MiB")
    waits = sorted(server.waits)
    late = sum(wait > 0.5 for wait in waits)
    return (
        f"server {server.memory} MiB; {len(waits)} other answers, median {statistics.median(waits) * 1000:.0f} ms, "
        f"slowest {waits[-1] * 1000:.0f} ms, {late} over 500 ms"
    )


def exhaust_memory(library: TrackedLibrary, rng: random.Random) -> str:
    """Run imports that need all memory, and check that the server still answers."""
    tracks = rng.randint(60_000, 120_000)
    rows = "".join(f"{1 + i % 70},{i + 1},10,10,20,20,1,1,1\n" for i in range(tracks))
    bombs = {"tracks": zipped({"gt/gt.txt": rows.encode()}), "zeros": zipped({"annotations.json": bytes(300 << 20)})}
    bombs["spaces"] = zipped({"annotations.xml": b"<annotations>" + b" " * (200 << 20) + b"</annotations>"})
    bombs["brackets"] = zipped({"annotations.json": b"[" * (50 << 20)})
    bombs["nested"] = zipped({"a.zip": bombs["zeros"], "b.zip": bombs["spaces"]})
    found = {}
    with start_server(library.home, library.environment) as server, server.monitored():
        for name, content in bombs.items():
            path = f"/api/videos/{library.video}/imports?as=truth&file={name}.zip&name={name}"
            found[name], answer = server.request(path, content)
            if not 400 <= found[name] < 500:
                raise BrokenGuaranteeError(f"{name} was answered with {found[name]}: {answer}")
    return f"{found}, {server_load(server)}"


def wait_for_edits(log: AnswerLog, count: int = 20) -> None:
    """Wait until so many more edits are acknowledged, without a deadline for busy machines."""
    wanted = len(log.acknowledged) + count
    while (remounted := len(log.acknowledged)) < wanted:
        try:
            wait_until(lambda remounted=remounted: len(log.acknowledged) > remounted)
        except AssertionError:
            raise BrokenGuaranteeError(f"edits are not taken any more: {dict(log.refused)}") from None


def wait_for_refusals(log: AnswerLog) -> None:
    """Wait until edits are answered with 507."""
    before = log.refused[507]
    try:
        wait_until(lambda: log.refused[507] >= before + 5)
    except AssertionError:
        raise BrokenGuaranteeError(f"edits are not refused with 507: {dict(log.refused)}") from None


def check_readable(server: ServerProcess, library: TrackedLibrary) -> None:
    """Check that reading works."""
    for path in (
        f"/api/videos/{library.video}",
        f"/api/runs/{library.run}/annotation",
        f"/api/runs/{library.run}/tracks",
    ):
        status, answer = server.request(path)
        if status != 200:
            raise BrokenGuaranteeError(f"nothing can be read while nothing can be written: {status} {answer}")


def limit_file_sizes(library: TrackedLibrary, rng: random.Random, people: int) -> str:
    """Stop files from growing for a while: reading works, edits wait, and everything continues afterwards."""
    log = AnswerLog()
    with (
        start_server(library.home, forked=True) as server,
        clients(library, lambda: server, log, people, rng),
    ):
        wait_for_edits(log)
        _, hard = resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))
        wait_for_refusals(log)
        check_readable(server, library)
        before = len(log.acknowledged)
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (hard, hard))
        wait_for_edits(log)
    check_log(library, log)
    return f"{before} acknowledged before, {len(log.acknowledged) - before} after, {dict(log.refused)}"


def make_disk_read_only(library: TrackedLibrary, rng: random.Random, people: int) -> str:
    """Make the kernel turn the file system read-only: reading works and edits wait until it is mounted again."""
    log = AnswerLog()
    with tempfile.TemporaryDirectory() as folder:
        try:
            with failing_disk(Path(folder), library.home) as disk:
                remounted = replace(library, home=disk.mount_point / library.home.name)
                with start_server(remounted.home) as server, clients(remounted, lambda: server, log, people, rng):
                    wait_for_edits(log)
                    # in the moment between the abort of its journal and the mark that it can only be read, ext4 says
                    # that it has synced what is lost: whoever writes then has no way to know, so nobody does
                    server.process.send_signal(signal.SIGSTOP)
                    time.sleep(0.5)
                    disk.fail()
                    server.process.send_signal(signal.SIGCONT)
                    wait_for_refusals(log)
                    check_readable(server, remounted)
                    before = len(log.acknowledged)
                disk.repair()
                check_log(remounted, log)
                with start_server(remounted.home) as server, clients(remounted, lambda: server, log, people, rng):
                    wait_for_edits(log)
                check_log(remounted, log)
        except DiskUnavailableError as error:
            return f"left out: {error}"
    return f"{before} acknowledged before, {len(log.acknowledged) - before} after, {dict(log.refused)}"


def jump_clock(library: TrackedLibrary, rng: random.Random, scale: Scale) -> str:
    """Clocks that jump by a day while people edit."""
    faketime = next((found for pattern in FAKETIME for found in Path("/").glob(pattern[1:])), None)
    if faketime is None:
        return "left out: libfaketime is not installed (on Debian: apt install faketime)"
    log = AnswerLog()
    with tempfile.TemporaryDirectory() as folder:
        clock = Path(folder) / "clock"
        clock.write_text("+0d")
        # Python sleeps until a monotonic time, which libfaketime (0.9.10) takes for wall-clock time
        sleeping = "import select, time\ntime.sleep = lambda seconds: select.select([], [], [], seconds) and None\n"
        (Path(folder) / "sitecustomize.py").write_text(sleeping)
        faked = {"LD_PRELOAD": str(faketime), "FAKETIME_TIMESTAMP_FILE": str(clock), "FAKETIME_NO_CACHE": "1"}
        faked |= {"FAKETIME_DONT_FAKE_MONOTONIC": "1", "PYTHONPATH": folder}
        few = min(6, scale.people)  # libfaketime reads that file at each call of the clock
        with start_server(library.home, faked) as server, clients(library, lambda: server, log, few, rng):
            for _ in range(scale.jumps):
                clock.write_text(rng.choice(("+1d", "-1d", "+0d", "+400d", "-400d")))
                wait_for_edits(log, 5)
    stored = check_log(library, log)
    return f"{scale.jumps} jumps: {len(log.acknowledged)} acknowledged, {stored} stored in order"
