"""The local executor runs orders in parallel up to a limit, retries after a death, and kills on a stop."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from tsr_engine.batch import executors
from tsr_engine.batch.executors import run_locally
from tsr_engine.batch.process import MAX_ATTEMPTS, run_task
from tsr_engine.batch.task import DriveTask, Outcome
from tsr_engine.errors import UsageError

ORDERS = [DriveTask(video=f"/{k}.mp4", folder=f"/out/{k}", parameters={}) for k in range(6)]


def never() -> bool:
    return False


def nothing(place: int, done: int, total: int | None) -> None:
    pass


def test_every_order_has_its_outcome(monkeypatch: pytest.MonkeyPatch) -> None:
    at_once = threading.Barrier(3, timeout=30)
    heard = []

    def fake(order: DriveTask, at: Callable[[int, int | None], None], *_: Any) -> Outcome:
        at_once.wait()
        at(1, 2)
        return Outcome({"video": order.video})

    monkeypatch.setattr(executors, "run_task", fake)
    found = dict(run_locally(ORDERS, 3, lambda *said: heard.append(said), never))
    assert {place: outcome.result for place, outcome in found.items()} == {
        place: {"video": order.video} for place, order in enumerate(ORDERS)
    }
    assert sorted(heard) == [(place, 1, 2) for place in range(6)]


def test_only_a_death_is_retried(monkeypatch: pytest.MonkeyPatch) -> None:
    tries: dict[str, int] = {}

    def fake(order: DriveTask, *_: Any) -> Outcome:
        tries[order.video] = tries.get(order.video, 0) + 1
        if order.video == "/0.mp4" and tries[order.video] < 2:
            return Outcome(None, "died", died=True)
        if order.video == "/1.mp4":
            return Outcome(None, "always dies", died=True)
        if order.video == "/2.mp4":
            return Outcome(None, "damaged")
        return Outcome({})

    monkeypatch.setattr(executors, "run_task", fake)
    found = dict(run_locally(ORDERS, 2, nothing, never))
    assert tries == {"/0.mp4": 2, "/1.mp4": MAX_ATTEMPTS, "/2.mp4": 1, "/3.mp4": 1, "/4.mp4": 1, "/5.mp4": 1}
    assert [found[k].error for k in range(3)] == ["", "always dies", "damaged"]


def test_a_stop_kills_running_orders(monkeypatch: pytest.MonkeyPatch) -> None:
    killed: list[int] = []

    def fake(order: DriveTask, at: Any, started: Callable[[Any], None], *_: Any) -> Outcome:
        with subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"], text=True) as process:
            started(process)
            killed.append(process.wait())
        return Outcome(None, "died", died=True)

    monkeypatch.setattr(executors, "run_task", fake)
    began = time.monotonic()
    assert list(run_locally(ORDERS, 2, nothing, lambda: time.monotonic() - began > 1)) == []
    assert killed == [-9, -9]


def test_the_cause_of_death_is_reported() -> None:
    outcome = run_task(ORDERS[0], on_start=lambda process: process.kill())
    assert outcome.died
    assert outcome.error == "Its process was killed, perhaps because the machine ran out of memory."


class Reference(tuple[Any, ...]):
    """One that can be a key, whatever it refers to."""

    __slots__ = ()
    __hash__ = object.__hash__


class Inline:
    """Ray that does everything at once, in this process."""

    exceptions = SimpleNamespace(RayError=OSError)

    def remote(self, **_: object) -> Callable[[Any], Any]:
        return self._called

    def _called(self, function: Any) -> Any:
        """A handle whose ``remote`` calls the function, or makes the actor of the class."""

        def remote(*arguments: Any) -> Any:
            made = function(*arguments)
            if isinstance(function, type):
                return SimpleNamespace(put=self._called(made.put), take=self._called(made.take))
            return Reference((made,))

        handle = SimpleNamespace(remote=remote)
        handle.options = lambda **_: handle
        return handle

    def wait(self, references: list[Any], **_: object) -> tuple[list[Any], list[Any]]:
        return references[:1], references[1:]

    def get(self, reference: Any, timeout: float = 0.0) -> Any:
        return reference[0]

    def cancel(self, _reference: Any, force: bool) -> None:
        pass

    def shutdown(self) -> None:
        pass


def test_notes_of_nodes_arrive(monkeypatch: pytest.MonkeyPatch) -> None:
    def run(order: DriveTask, note: Callable[[str], None]) -> Outcome:
        note(f"compiling for {order.video}")
        return Outcome(None, "no such file")

    monkeypatch.setattr(executors, "connect", lambda address, start_local: Inline())
    monkeypatch.setattr(executors, "run_task", run)
    heard: list[str] = []
    ended = list(executors.run_on_ray(ORDERS[:2], None, nothing, never, heard.append))
    assert [place for place, _ in ended] == [0, 1]
    assert heard == ["compiling for /0.mp4", "compiling for /1.mp4"]


class Dying(Inline):
    """Ray whose nodes die."""

    retries: object = None

    def remote(self, **options: object) -> Callable[[Any], Any]:
        self.retries = options.get("max_retries", self.retries)
        return super().remote()

    def get(self, reference: Any, timeout: float = 0.0) -> Any:
        raise self.exceptions.RayError("the node died")


def test_a_drive_is_given_up_after_as_many_tries_as_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    ray = Dying()
    monkeypatch.setattr(executors, "connect", lambda address, start_local: ray)
    monkeypatch.setattr(executors, "run_task", lambda *_, **__: Outcome({}))
    ((_, outcome),) = executors.run_on_ray(ORDERS[:1], None, nothing, never)
    assert outcome.error == f"Ray gave the drive up after {MAX_ATTEMPTS} tries: the node died"
    assert ray.retries == MAX_ATTEMPTS - 1, "the first try is no retry"


def test_without_ray_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(UsageError, match=r"pip install 'tsr\[cluster\]'"):
        next(iter(executors.run_on_ray(ORDERS, None, nothing, never)))
