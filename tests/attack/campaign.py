"""The attack at length: ``python -m tests.attack.campaign --kills 200 --hours 1 --seed 1``, or ``make attack``.

A server of its own, on a toy drive, goes through kills with many clients, imports of files that were damaged at random,
imports that ask for all memory, a disk that cannot be written, and clocks that jump (where libfaketime is installed).
Every stage says what it has seen. The first broken promise ends the campaign with its seed, and exit code 1.
"""

from __future__ import annotations

import argparse
import io
import json
import random
import resource
import shutil
import sqlite3
import sys
import tempfile
import threading
import time
import uuid
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from http.client import HTTPException
from pathlib import Path

from tests.app.toy_home import make_home
from tests.attack.own_server import Running, running

MOST_MB = 600
"""Memory of the server, MiB."""
SLOWEST = 5.0
"""Seconds that an answer to something small may take on a machine that does nothing else."""
FAKETIME = ("/usr/lib/*/faketime/libfaketime.so.1", "/usr/lib/faketime/libfaketime.so.1")


class BrokenPromiseError(Exception):
    """What must never happen has happened."""


@dataclass
class Log:
    """What clients were reported.

    Attributes:
        acknowledged: operations that the server has answered with 200.
        refused: how often each other status came.
    """

    acknowledged: set[str] = field(default_factory=set)
    refused: Counter[int] = field(default_factory=Counter)


@dataclass(frozen=True)
class Place:
    """A data folder with one run."""

    home: Path
    video: str
    run: str


def client(place: Place, server: Callable[[], Running], log: Log, seed: int, done: threading.Event) -> None:
    """Relabel tracks until the end; what was not answered is sent again, as the page does."""
    chance = random.Random(seed)
    author = f"client-{seed % 1000}"
    while not done.is_set():
        op_id, key = uuid.UUID(int=chance.getrandbits(128)).hex, chance.choice(("m1", "m2"))
        revision = -1
        while not done.is_set():
            try:
                if revision < 0:
                    _, said = server().ask(f"/api/runs/{place.run}/annotation?author={author}", timeout=10)
                    revision = next((doc["revision"] for doc in said["docs"] if doc["key"] == key), 0)
                command = {"name": "relabel_track", "key": key, "frame": 20, "class_id": chance.randrange(43)}
                body = json.dumps({"op_id": op_id, "author": author, "command": command}).encode()
                headers = {"If-Match": f'"{key}:{revision}"', "Content-Type": "application/json"}
                status, _ = server().ask(f"/api/runs/{place.run}/edits", body, timeout=10, more=headers)
            except (OSError, HTTPException, ValueError, KeyError):
                time.sleep(0.05)  # the server is down: the same operation again
                continue
            if status == 200:
                log.acknowledged.add(op_id)
                break
            log.refused[status] += 1
            if status not in (409, 412, 503, 507):
                raise BrokenPromiseError(f"an edit was answered with {status}")
            if status in (409, 412):
                op_id, revision = uuid.UUID(int=chance.getrandbits(128)).hex, -1  # a person would look, and decide anew
            else:
                time.sleep(0.1)


@contextmanager
def clients(place: Place, server: Callable[[], Running], log: Log, count: int, seed: int) -> Iterator[None]:
    """Some clients that edit meanwhile; what they find broken is raised at the end."""
    done, broken = threading.Event(), list[BaseException]()

    def work(number: int) -> None:
        try:
            client(place, server, log, seed * 1000 + number, done)
        except BaseException as error:
            broken.append(error)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    try:
        yield
    finally:
        done.set()
        for thread in threads:
            thread.join()
    if broken:
        raise broken[0]


def check_log(place: Place, log: Log) -> int:
    """Every acknowledged operation is stored exactly once, and the database is sound; number of operations."""
    with closing(sqlite3.connect(place.home / "tsr.sqlite")) as database:
        if database.execute("PRAGMA integrity_check").fetchall() != [("ok",)]:
            raise BrokenPromiseError("the database is damaged")
        stored = Counter(row[0] for row in database.execute("SELECT op_id FROM edits"))
        order = [row[0] for row in database.execute("SELECT seq FROM edits ORDER BY rowid")]
    lost = log.acknowledged - stored.keys()
    twice = [op_id for op_id, count in stored.items() if count > 1]
    if lost or twice or order != sorted(order):
        raise BrokenPromiseError(f"{len(lost)} acknowledged edits lost, {len(twice)} stored twice")
    return len(stored)


def kills(place: Place, chance: random.Random, count: int, people: int) -> str:
    """Kill the server again and again while people edit."""
    log, current = Log(), list[Running]()

    def live() -> None:
        for _ in range(count):
            with running(place.home) as server:
                current[:] = [server]
                time.sleep(chance.uniform(0.0, 2.0))

    with running(place.home) as first:
        current[:] = [first]
    with clients(place, lambda: current[0], log, people, chance.randrange(1000)):
        killer = threading.Thread(target=live)
        killer.start()
        killer.join()
    stored = check_log(place, log)
    return (
        f"{count} kills, {people} clients: {len(log.acknowledged)} acknowledged, {stored} stored, {dict(log.refused)}"
    )


def fuzzed(place: Place, chance: random.Random, seconds: float, least: int) -> str:
    """Import files that were damaged at random."""
    statuses: Counter[int] = Counter()
    slowest, memory, done = 0.0, 0, 0
    with running(place.home) as server, server.watched():
        originals = [exported(), plain_rows(), cvat()]
        until = time.monotonic() + seconds
        while time.monotonic() < until or done < least:
            name, content = chance.choice(originals)
            kind = chance.choice(("truth", "annotation", "run"))
            path = f"/api/videos/{place.video}/imports?as={kind}&file={name}&name=fuzzed&run={place.run}"
            began = time.monotonic()
            status, said = server.ask(path, damaged(content, chance))
            slowest = max(slowest, time.monotonic() - began)
            statuses[status] += 1
            if status >= 500:
                raise BrokenPromiseError(f"import {done} was answered with {status}: {said}")
            done += 1
        memory = max(memory, server.memory)
    if memory > MOST_MB:
        raise BrokenPromiseError(f"the server held {memory} MiB")
    return f"{done} damaged files: {dict(statuses)}, slowest {slowest:.1f} s, server {memory} MiB"


def exported() -> tuple[str, bytes]:
    """An archive of MOT rows."""
    rows = "".join(f"{frame},{track},{10 + frame},10,20,20,1,1,1\n" for track in (1, 2) for frame in range(1, 70))
    return "rows.zip", zipped({"gt/gt.txt": rows.encode()})


def plain_rows() -> tuple[str, bytes]:
    """A table."""
    rows = "".join(f"{frame},{track},{10 + frame},10,{30 + frame},30,14\n" for track in (1, 2) for frame in range(70))
    return "rows.csv", b"frame,track_id,x1,y1,x2,y2,class_id\n" + rows.encode()


def cvat() -> tuple[str, bytes]:
    """CVAT's XML."""
    box = '<box frame="{}" xtl="{}" ytl="10" xbr="60" ybr="30" outside="0" occluded="0" keyframe="1"/>'
    tracks = "".join(
        f'<track id="{i}" label="stop">{box.format(3, 20 + i)}{box.format(60, 30 + i)}</track>' for i in range(5)
    )
    return "a.xml", f"<annotations><version>1.1</version>{tracks}</annotations>".encode()


def zipped(files: dict[str, bytes]) -> bytes:
    """A ZIP archive."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return out.getvalue()


def damaged(content: bytes, chance: random.Random) -> bytes:
    """The bytes with some flipped, cut out, doubled, or replaced by what hurts parsers."""
    data = bytearray(content)
    hurts = (b"NaN", b"-1", b"9" * 40, b"1e999", b"\0", b"<!DOCTYPE a>", b"\xff\xfe", b'"', b"../", b"<", b"\n")
    for _ in range(chance.randint(1, 6)):
        at = chance.randrange(len(data) + 1)
        what = chance.randrange(4)
        if what == 0 and at < len(data):
            data[at] ^= 1 << chance.randrange(8)
        elif what == 1:
            del data[at : at + chance.randint(1, 200)]
        elif what == 2:
            data[at:at] = data[at : at + chance.randint(1, 2000)]
        else:
            data[at : at + 3] = chance.choice(hurts)
    return bytes(data) or b"x"


def exhausted(place: Place, chance: random.Random) -> str:
    """Import what asks for all memory, and keep answering."""
    tracks = chance.randint(60_000, 120_000)
    rows = "".join(f"{1 + i % 70},{i + 1},10,10,20,20,1,1,1\n" for i in range(tracks))
    bombs = {"tracks": zipped({"gt/gt.txt": rows.encode()}), "zeros": zipped({"annotations.json": bytes(300 << 20)})}
    bombs["spaces"] = zipped({"annotations.xml": b"<annotations>" + b" " * (200 << 20) + b"</annotations>"})
    bombs["brackets"] = zipped({"annotations.json": b"[" * (50 << 20)})
    found = {}
    with running(place.home) as server, server.watched():
        for name, content in bombs.items():
            path = f"/api/videos/{place.video}/imports?as=truth&file={name}.zip&name={name}"
            found[name], said = server.ask(path, content)
            if not 400 <= found[name] < 500:
                raise BrokenPromiseError(f"{name} was answered with {found[name]}: {said}")
    if server.memory > MOST_MB:
        raise BrokenPromiseError(f"the server held {server.memory} MiB")
    return f"{found}, server {server.memory} MiB, slowest other answer {max(server.waits):.2f} s"


def unwritable(place: Place, chance: random.Random, people: int) -> str:
    """Files that cannot grow for a while: reading works, edits wait, and all goes on afterwards."""
    log = Log()
    with running(place.home) as server, clients(place, lambda: server, log, people, chance.randrange(1000)):
        time.sleep(1.5)
        before = len(log.acknowledged)
        _, hard = resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))
        time.sleep(2)
        if server.ask(f"/api/videos/{place.video}")[0] != 200:
            raise BrokenPromiseError("nothing can be read while nothing can be written")
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (hard, hard))
        time.sleep(3)
        after = len(log.acknowledged)
    check_log(place, log)
    if after <= before:
        raise BrokenPromiseError("edits are not taken again once files can grow")
    return f"{before} acknowledged before, {after - before} after, {dict(log.refused)}"


def jumping(place: Place, chance: random.Random, people: int) -> str:
    """Clocks that jump by a day while people edit."""
    library = next((found for place_ in FAKETIME for found in Path("/").glob(place_[1:])), None)
    if library is None:
        return "left out: libfaketime is not installed (on Debian: apt install faketime)"
    log = Log()
    with tempfile.TemporaryDirectory() as folder:
        clock = Path(folder) / "clock"
        clock.write_text("+0d")
        more = {"LD_PRELOAD": str(library), "FAKETIME_TIMESTAMP_FILE": str(clock), "FAKETIME_NO_CACHE": "1"}
        more["FAKETIME_DONT_FAKE_MONOTONIC"] = "1"
        with (
            running(place.home, more) as server,
            clients(place, lambda: server, log, people, chance.randrange(1000)),
        ):
            for _ in range(6):
                clock.write_text(chance.choice(("+1d", "-1d", "+0d")))
                time.sleep(1)
    stored = check_log(place, log)
    return f"6 jumps: {len(log.acknowledged)} acknowledged, {stored} stored in order"


def campaign(folder: Path, seed: int, count: int, seconds: float, people: int, least: int = 20) -> dict[str, str]:
    """All stages, each on a data folder of its own; what each has seen.

    Args:
        folder: empty.
        seed: of everything that is random.
        count: how often the server is killed.
        seconds: for damaged files.
        people: clients at once.
        least: damaged files at least.

    Raises:
        BrokenPromiseError: the first promise that does not hold.
    """
    made = make_home(folder / "toy")
    made.evidence.close()
    made.database.close()
    stages: dict[str, Callable[[Place, random.Random], str]] = {
        "kills": lambda place, chance: kills(place, chance, count, people),
        "damaged files": lambda place, chance: fuzzed(place, chance, seconds, least),
        "memory": exhausted,
        "disk": lambda place, chance: unwritable(place, chance, people),
        "clock": lambda place, chance: jumping(place, chance, people),
    }
    said = {}
    for name, stage in stages.items():
        place = Place(folder / name.replace(" ", "-"), made.video_id, made.run_id)
        shutil.copytree(made.settings.home, place.home)
        try:
            said[name] = stage(place, random.Random(f"{seed} {name}"))
        except BrokenPromiseError as error:
            raise BrokenPromiseError(f"{name}, seed {seed}: {error}") from error
        print(f"{name}: {said[name]}", flush=True)
    return said


def main() -> int:
    """Run it from the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--kills", type=int, default=200, help="how often the server is killed")
    parser.add_argument("--hours", type=float, default=1.0, help="how long damaged files are imported")
    parser.add_argument("--clients", type=int, default=20, help="people who edit meanwhile")
    parser.add_argument("--seed", type=int, default=1, help="of everything that is random")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tsr-attack-") as folder:
        try:
            campaign(Path(folder), asked.seed, asked.kills, asked.hours * 3600, asked.clients)
        except BrokenPromiseError as error:
            print(f"BROKEN: {error}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
