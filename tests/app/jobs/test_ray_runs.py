"""Runs and a batch on a Ray cluster: a node dies, a run is cancelled, a node has other models, or compiles."""

from __future__ import annotations

import base64
import json
import os
import pickle
import resource
import shutil
import signal
import sys
import threading
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba
import pytest
from pydantic import ValidationError

from app.context import build_context
from app.runs import executor
from app.settings import Settings
from tests.app.jobs.same_evidence import assert_same_evidence
from tests.batch.ray_batch import PARAMS
from tests.batch.short_drives import write_short_drive
from tests.forked_program import ForkedProgram
from tsr_engine.batch import node_runner, node_worker
from tsr_engine.batch.cluster import ClusterUnreachable
from tsr_engine.batch.node_runner import run_on_node
from tsr_engine.batch.node_task import NodeTask
from tsr_engine.compilation import COMPILING
from tsr_engine.extras import MissingExtra
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components
from tsr_engine.runs.track_video import RunReport, RunRequest, track_video

DRIVES = 3


@dataclass(frozen=True)
class RayOutcomes:
    """What became of the runs and of the batch, and the folder with the batch's drives and results."""

    found: dict[str, Any]
    folder: Path


@pytest.fixture(scope="module")
def outcomes(imported_home: Path, tmp_path_factory: pytest.TempPathFactory) -> RayOutcomes:
    """Those of one cluster, see ``ray_cluster.py``."""
    pytest.importorskip("ray", reason="Ray is not installed: pip install 'tsr[cluster]'")
    folder = tmp_path_factory.mktemp("ray")
    shutil.copytree(imported_home, folder / "home")
    (folder / "drives").mkdir()
    for number in range(DRIVES):
        write_short_drive(folder / "drives" / f"d{number}.mp4", 12 + number)
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "RAY_USAGE_STATS_ENABLED": "0",
    }
    arguments = [str(folder / name) for name in ("home", "drives", "out")]
    process = ForkedProgram("tests.app.jobs.ray_cluster:main", arguments, environment)
    try:
        assert process.wait(400) == 0
    finally:
        process.kill()
    return RayOutcomes(json.loads((folder / "outcomes.json").read_text()), folder)


@pytest.mark.slow
def test_a_run_resumes_after_the_death_of_a_node(outcomes: RayOutcomes, reference_run: Path) -> None:
    found = outcomes.found
    assert found["waited"]
    assert found["ends"] == {"killed": 1}
    assert found["crashes"] == 0
    assert found["tokens"] >= 2
    assert found["refused"].startswith("ModelError: ")
    assert "has another detector than this work was started with" in found["refused"]
    assert_same_evidence(reference_run, Path(found["folder"]))


@pytest.mark.slow
def test_a_batch_survives_the_death_of_a_node(outcomes: RayOutcomes, tmp_path: Path) -> None:
    found = outcomes.found["batch"]
    assert found["killed_after"] == [1]
    assert found["states"] == {f"d{number}": ["done", ""] for number in range(DRIVES)}
    assert (found["second_call"], found["same"]) == (0, True)
    parts = load_components(PARAMS)
    for number in range(DRIVES):
        plain = tmp_path / f"{number}.csv"
        track_video(RunRequest(outcomes.folder / "drives" / f"d{number}.mp4", PARAMS, csv=plain), parts)
        rows = plain.read_bytes()
        assert rows.count(b"\n") > 10, "there are signs to be found"
        assert (outcomes.folder / "out" / f"d{number}" / "tracks.csv").read_bytes() == rows


def test_a_run_waits_for_a_computing_node(monkeypatch: pytest.MonkeyPatch) -> None:
    class Head:
        """A cluster with only its head node."""

        def nodes(self) -> list[dict[str, object]]:
            return [{"Alive": True, "Resources": {"memory": 1.0}}, {"Alive": False, "Resources": {"CPU": 8.0}}]

        def shutdown(self) -> None:
            pass

    monkeypatch.setattr("tsr_engine.batch.node_runner.connect", lambda address, start_local: Head())
    order = NodeTask(RunRequest(Path("drive.mp4"), Params()), None, {})
    with pytest.raises(ClusterUnreachable, match="no node with a CPU"):
        run_on_node(order, None, lambda _: None, lambda: False)


def test_without_ray_a_server_refuses_to_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tsr_engine.extras.find_spec", lambda name: None)
    with pytest.raises(MissingExtra, match=r"needs ray, which is not installed: pip install 'tsr\[cluster\]'"):
        build_context(Settings(home=tmp_path / "home", executor="ray://head:10001"))
    assert not (tmp_path / "home").exists()


AT = {"done": 1, "total": 8, "rate": None, "remaining": None}
REPORT = RunReport("drive.mp4", 320, 240)


class Node:
    """A cluster that is one node, and the actor on it.

    Args:
        said: what the node's process says.
        busy: number of looks until the node has a free CPU.
    """

    exceptions = SimpleNamespace(RayActorError=OSError, GetTimeoutError=TimeoutError)

    def __init__(self, *said: dict[str, object], busy: int = 0) -> None:
        done = base64.b64encode(pickle.dumps(REPORT)).decode()
        self._lines = [json.dumps(line) for line in (*said, {"done": done})]
        self._busy = busy

    def __getattr__(self, name: str) -> Any:
        answer = (self._lines, None) if name == "poll" else self
        return SimpleNamespace(remote=lambda *_: answer)

    def nodes(self) -> list[dict[str, object]]:
        return [{"Alive": True, "Resources": {"CPU": 1.0}}]

    def remote(self, _class: object = None) -> Node:
        return self

    def options(self, **_: object) -> Node:
        return self

    def wait(self, waited: list[object], timeout: float) -> tuple[list[object], list[object]]:
        self._busy -= 1
        return ([], waited) if self._busy >= 0 else (waited, [])

    def get(self, value: object, timeout: float = 0.0) -> object:
        return value

    def kill(self, _actor: object) -> None:
        pass

    def shutdown(self) -> None:
        pass


def heard(monkeypatch: pytest.MonkeyPatch, node: Node) -> list[object]:
    """Notes, and numbers of frames done, of a run on a node."""
    monkeypatch.setattr("tsr_engine.batch.node_runner.connect", lambda address, start_local: node)
    heard: list[object] = []
    order = NodeTask(RunRequest(Path("drive.mp4"), Params()), None, {})
    report = run_on_node(order, None, lambda progress: heard.append(progress.done), lambda: False, heard.append)
    assert report is not None
    return heard


def test_the_note_of_a_node_is_passed_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """The lines of the node's process arrive in order."""
    node = Node({"note": "it compiles"}, {"at": AT}, {"note": ""})
    assert heard(monkeypatch, node) == ["", "it compiles", 1, ""]


def test_a_run_that_waits_for_a_free_cpu_says_so_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(node_runner, "NOTE_AFTER_S", 0.0)
    assert heard(monkeypatch, Node({"at": AT}, busy=3)) == [node_runner.WAITING_FOR_NODE, "", 1]


def test_a_run_that_waits_for_the_cluster_says_each_reason_once(monkeypatch: pytest.MonkeyPatch) -> None:
    notes: list[str] = []
    answers: list[object] = [*map(ClusterUnreachable, ("No answer.", "No answer.", "No CPU.")), REPORT]

    def run_on_node(*_: object) -> object:
        answer = answers.pop(0)
        if isinstance(answer, ClusterUnreachable):
            raise answer
        return answer

    limits, on_sigterm = resource.getrlimit(resource.RLIMIT_AS), signal.getsignal(signal.SIGTERM)
    monkeypatch.setattr(executor, "RETRY_DELAY_S", 0.0)
    monkeypatch.setattr(executor, "run_on_node", run_on_node)
    settings = Settings(executor="ray://head:10001")
    task: Any = SimpleNamespace(settings=settings, note=notes.append, should_stop=lambda: False)
    components: Any = SimpleNamespace(models={})
    try:
        request = RunRequest(Path("drive.mp4"), Params())
        report = executor.run_engine(task, request, components, None, lambda _: None)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limits)
        signal.signal(signal.SIGTERM, on_sigterm)
    assert report is REPORT
    assert notes == ["waiting. No answer", "waiting. No CPU"]


def test_a_node_says_that_it_compiles(monkeypatch: pytest.MonkeyPatch) -> None:
    notes: list[dict[str, object]] = []
    kernel, over = numba.njit(lambda x: x + 1), threading.Event()

    def say(message: dict[str, object]) -> None:
        notes.append(message)
        if message == {"note": ""}:
            over.set()

    def compiled(*_: object, **__: object) -> str:
        kernel(1)
        assert over.wait(60)
        return "the report"

    monkeypatch.setattr("tsr_engine.batch.child_process.send_message", say)
    monkeypatch.setattr(node_worker, "PROGRESS_INTERVAL_S", 0.01)
    monkeypatch.setattr("tsr_engine.compilation.NEXT_KERNEL_S", 0.3)
    monkeypatch.setattr("tsr_engine.runs.track_video.track_video", compiled)
    order = NodeTask(RunRequest(Path("drive.mp4"), Params()), None, {}, memory_mb=0)
    assert node_worker.run_task(order, []) == "the report"  # type: ignore[comparison-overlap]
    assert notes == [{"note": COMPILING}, {"note": ""}]


@pytest.mark.parametrize("text", ["spark", "ray://", "ray://head", "ray://head:x", "RAY", "ray://he ad:1"])
def test_an_executor_is_one_of_three(text: str) -> None:
    with pytest.raises(ValidationError):
        Settings(executor=text)
