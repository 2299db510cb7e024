"""Runs of the review tool on a Ray cluster: a node dies, a run is cancelled, a node has other models."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from pydantic import ValidationError

from app.context import build_context
from app.settings import Settings
from tests.app.jobs.same import assert_same
from tsr_engine.batch.cluster import Unreachable
from tsr_engine.batch.on_node import run_on_node
from tsr_engine.batch.run_order import RunOrder
from tsr_engine.extras import MissingExtra
from tsr_engine.params import Params
from tsr_engine.runs.live import RunRequest

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

    monkeypatch.setattr("tsr_engine.batch.on_node.connected", lambda address, alone: Head())
    order = RunOrder(RunRequest(Path("drive.mp4"), Params()), None, {})
    with pytest.raises(Unreachable, match="no node with a CPU"):
        run_on_node(order, None, lambda _: None, lambda: False)


def test_without_ray_a_server_refuses_to_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tsr_engine.extras.find_spec", lambda name: None)
    with pytest.raises(MissingExtra, match=r"needs ray, which is not installed: pip install 'tsr\[cluster\]'"):
        build_context(Settings(home=tmp_path / "home", executor="ray://head:10001"))
    assert not (tmp_path / "home").exists()


@pytest.mark.parametrize("text", ["spark", "ray://", "ray://head", "ray://head:x", "RAY", "ray://he ad:1"])
def test_an_executor_is_one_of_three(text: str) -> None:
    with pytest.raises(ValidationError):
        Settings(executor=text)
