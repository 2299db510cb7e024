"""Runs of the review tool on a Ray cluster: a node dies, a run is cancelled, a node has other models, or compiles."""

from __future__ import annotations

import base64
import json
import os
import pickle
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba
import pytest
from pydantic import ValidationError

from app.context import build_context
from app.settings import Settings
from tests.app.jobs.same import assert_same
from tsr_engine.batch import node_worker
from tsr_engine.batch.cluster import ClusterUnreachable
from tsr_engine.batch.node_runner import run_on_node
from tsr_engine.batch.node_task import NodeTask
from tsr_engine.compiling import COMPILING
from tsr_engine.extras import MissingExtra
from tsr_engine.params import Params
from tsr_engine.runs.live import RunReport, RunRequest

SCRIPT = Path(__file__).with_name("ray_office.py")


@pytest.mark.slow
def test_a_run_resumes_after_the_death_of_a_node(undisturbed: Path, tmp_path: Path) -> None:
    pytest.importorskip("ray", reason="Ray is not installed: pip install 'tsr[cluster]'")
    paths = os.pathsep.join(filter(None, sys.path))
    done = subprocess.run(
        [sys.executable, str(SCRIPT), str(tmp_path / "home")],
        capture_output=True,
        text=True,
        timeout=400,
        env={**os.environ, "PYTHONPATH": paths, "RAY_USAGE_STATS_ENABLED": "0"},
    )
    assert done.returncode == 0, done.stderr[-3000:]
    found = json.loads(done.stdout.strip().splitlines()[-1])
    assert found["waited"]
    assert found["ends"] == {"killed": 1}
    assert found["crashes"] == 0
    assert found["tokens"] >= 2
    assert found["refused"].startswith("ModelError: ")
    assert "has another detector than this work was started with" in found["refused"]
    assert_same(undisturbed, Path(found["folder"]))


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


def test_the_note_of_a_node_is_passed_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """The lines of the node's process arrive in order."""
    at = {"done": 1, "total": 8, "rate": None, "remaining": None}
    done = base64.b64encode(pickle.dumps(RunReport("drive.mp4", 320, 240))).decode()
    lines = [json.dumps(line) for line in ({"note": "it compiles"}, {"at": at}, {"note": ""}, {"done": done})]

    class Node:
        """A cluster that is one node, and the actor on it."""

        exceptions = SimpleNamespace(RayActorError=OSError, GetTimeoutError=TimeoutError)

        def __getattr__(self, name: str) -> Any:
            answer = (lines, None) if name == "poll" else self
            return SimpleNamespace(remote=lambda *_: answer)

        def nodes(self) -> list[dict[str, object]]:
            return [{"Alive": True, "Resources": {"CPU": 1.0}}]

        def remote(self, _class: object = None) -> Node:
            return self

        def options(self, **_: object) -> Node:
            return self

        def wait(self, waited: list[object], timeout: float) -> tuple[list[object], list[object]]:
            return waited, []

        def get(self, value: object, timeout: float = 0.0) -> object:
            return value

        def kill(self, _actor: object) -> None:
            pass

        def shutdown(self) -> None:
            pass

    monkeypatch.setattr("tsr_engine.batch.node_runner.connect", lambda address, start_local: Node())
    heard: list[object] = []
    order = NodeTask(RunRequest(Path("drive.mp4"), Params()), None, {})
    report = run_on_node(order, None, lambda progress: heard.append(progress.done), lambda: False, heard.append)
    assert report is not None
    assert heard == ["it compiles", 1, ""]


def test_a_node_says_that_it_compiles(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[dict[str, object]] = []
    kernel, over = numba.njit(lambda x: x + 1), threading.Event()

    def say(message: dict[str, object]) -> None:
        said.append(message)
        if message == {"note": ""}:
            over.set()

    def compiled(*_: object, **__: object) -> str:
        kernel(1)
        assert over.wait(60)
        return "the report"

    monkeypatch.setattr("tsr_engine.batch.child_process.send_message", say)
    monkeypatch.setattr(node_worker, "PROGRESS_INTERVAL_S", 0.01)
    monkeypatch.setattr("tsr_engine.compiling.NEXT", 0.3)
    monkeypatch.setattr("tsr_engine.runs.live.track_video", compiled)
    order = NodeTask(RunRequest(Path("drive.mp4"), Params()), None, {}, memory_mb=0)
    assert node_worker.run_task(order, []) == "the report"  # type: ignore[comparison-overlap]
    assert said == [{"note": COMPILING}, {"note": ""}]


@pytest.mark.parametrize("text", ["spark", "ray://", "ray://head", "ray://head:x", "RAY", "ray://he ad:1"])
def test_an_executor_is_one_of_three(text: str) -> None:
    with pytest.raises(ValidationError):
        Settings(executor=text)
