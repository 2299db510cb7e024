"""Twenty signed-in people edit one drive while PostgreSQL restarts: checks that no edit is lost, and measures times."""

from __future__ import annotations

import os
import random
import statistics
import tempfile
import time
from contextlib import closing
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

from app.events import EventBus
from app.people.service import PeopleService
from app.settings import Settings
from app.storage.database import Database
from benchmarks.experiment import Data, Experiment, Result, Skip
from benchmarks.reporting.markdown import table
from benchmarks.timing.processes import processor_seconds
from tsr_engine.json_shapes import JsonObject

if TYPE_CHECKING:
    from app.people.roles import Role
    from tests.app.databases import Cluster
    from tests.attack.concurrent_editors import AnswerLog, TrackedLibrary
    from tests.attack.server_process import ServerProcess

PEOPLE = 20
SECONDS = 60.0
EVERY = 12.0
"""Seconds between two restarts of the database."""
STEADY = 2.0
"""Largest pause between an answer and the next edit of a fast person, s; half of it on average."""
MAX_MS = 200.0
"""Time limit for 95 % of the edits, ms."""


def _run(data: Data) -> Result:
    import pytest

    from tests.app.databases import new_database, running_cluster
    from tests.attack.concurrent_editors import MAX_PAUSE_S, AnswerLog, check_log
    from tests.attack.libraries import sample_library
    from tests.attack.server_process import start_server

    rng = random.Random(data.seed)  # noqa: S311 - decides who edits when
    try:
        with running_cluster() as cluster, tempfile.TemporaryDirectory(prefix="tsr-clients-") as folder:
            figures, stored = {}, 0
            paces = {"an edit a second": STEADY, "in a hurry": MAX_PAUSE_S}
            for name, outages in (("SQLite", {}), ("PostgreSQL", {"PostgreSQL that restarts": EVERY})):
                url = None if name == "SQLite" else new_database(cluster.url)
                made, _ = sample_library(Path(folder) / name, url)
                library, whole = replace(made, people=_people(made)), AnswerLog()
                for (stage, every), (pace, max_pause) in product({name: None, **outages}.items(), paces.items()):
                    with start_server(library.home, library.environment) as server:
                        outcome = _stage(server, library, rng, cluster, data.seconds or SECONDS, every, max_pause)
                    figures[f"{stage}, {pace}"], log = outcome
                    whole.acknowledged |= log.acknowledged
                stored += check_log(library, whole)  # raises if an edit is lost or stored twice
    except pytest.skip.Exception as without:
        raise Skip(str(without)) from None
    return Result(
        data=f"The longer sample drive, tracked by the engine, on SQLite and on PostgreSQL 15. {PEOPLE} people (5 "
        "reviewers, 15 annotators), each with a token and a persistent connection, relabel its tracks, three on each "
        f"track. Each waits up to {STEADY:g} s after an answer, or up to {MAX_PAUSE_S:g} s in a hurry.",
        figures={"stages": figures, "stored": stored},
        settings={"seed": data.seed, "every": EVERY},
    )


def _stage(
    server: ServerProcess,
    library: TrackedLibrary,
    rng: random.Random,
    cluster: Cluster,
    seconds: float,
    every: float | None,
    max_pause: float,
) -> tuple[JsonObject, AnswerLog]:
    """Let people edit for ``seconds``, while the database restarts every ``every`` seconds."""
    from tests.attack.concurrent_editors import AnswerLog, clients
    from tests.waiting import wait_until

    log, who = AnswerLog(), {"Authorization": f"Bearer {library.people[0][1]}"}
    # The evidence is read once.
    wait_until(lambda: server.request(f"/api/runs/{library.run}/tracks", more=who)[0] == 200)
    began, used = time.monotonic(), processor_seconds(server.process.pid)
    with clients(library, lambda: server, log, PEOPLE, rng, max_pause):
        outages = _restarts(cluster, seconds, every)
    took, used = time.monotonic() - began, processor_seconds(server.process.pid) - used
    return _figures(log, took, used, outages), log


def _people(library: TrackedLibrary) -> tuple[tuple[str, str], ...]:
    """Names and tokens of new accounts."""
    settings = Settings(home=library.home, database_url=library.database_url)
    with closing(Database(settings.database)) as database:
        service = PeopleService(database, EventBus())
        service.add("Adam", "admin")
        roles: list[Role] = ["reviewer" if number % 4 == 0 else "annotator" for number in range(PEOPLE)]
        return tuple((name := f"client {n}", service.add(name, role)[1]) for n, role in enumerate(roles))


def _restarts(cluster: Cluster, seconds: float, every: float | None) -> int:
    """Wait for ``seconds``; restart the database regularly, every second time as after a crash. Returns the count."""
    end, count = time.monotonic() + seconds, 0
    while (left := end - time.monotonic()) > 0:
        time.sleep(min(left, every or left))
        if every is not None and time.monotonic() < end:
            cluster.stop(("fast", "immediate")[count % 2])
            cluster.start()
            count += 1
    return count


def _figures(log: AnswerLog, took: float, used: float, outages: int) -> JsonObject:
    twentieths = statistics.quantiles(log.waits, n=20)
    return {
        "seconds": round(took, 1),
        "acknowledged": len(log.acknowledged),
        "refused": {str(status): count for status, count in sorted(log.refused.items())},
        "restarts": outages,
        "median_ms": round(1000 * twentieths[9], 1),
        "p95_ms": round(1000 * twentieths[18], 1),
        "slowest_ms": round(1000 * max(log.waits), 1),
        "server_ms": round(1000 * used / max(1, len(log.acknowledged) + sum(log.refused.values())), 1),
        "load": round(os.getloadavg()[0], 1),
    }


def _report(result: Result) -> str:
    stages: JsonObject = result.figures["stages"]
    rows = [["", "edits", "restarts", "median", "95 %", "slowest", "server time an edit", "refused"]]
    for name, one in stages.items():
        others = ", ".join(f"{count} of {status}" for status, count in one["refused"].items()) or "none"
        waits = (f"{one[key]:.0f} ms" for key in ("median_ms", "p95_ms", "slowest_ms", "server_ms"))
        rows.append(
            [f"{name}, {one['seconds']:.0f} s", f"{one['acknowledged']:,}", str(one["restarts"]), *waits, others]
        )
    acknowledged = sum(one["acknowledged"] for one in stages.values())
    late = [name for name, one in stages.items() if one["p95_ms"] > MAX_MS]
    verdict = f"missed by {' and '.join(late)}" if late else "met"
    loads = ", ".join(f"{one['load']:.0f}" for one in stages.values())
    stored = result.figures["stored"]
    return (
        f"{table(rows)}\n{acknowledged:,} edits were acknowledged and {stored:,} are stored: none is lost or stored "
        f"twice. Bar: 95 % within {MAX_MS:g} ms, {verdict}. The load of the machine was {loads}, with clients, server "
        "and database. The page sends an edit again after a 503; a 409 means that somebody else has changed the track "
        "in the meantime.\n"
    )


EXPERIMENT = Experiment(
    "clients",
    "Twenty people on one server",
    "Does the server keep every acknowledged edit while its database restarts, and how long does an edit take?",
    _run,
    _report,
)
