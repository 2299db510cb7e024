"""A batch on two Ray nodes, one of which is killed in the middle."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.batch.short_drives import write_short_drive
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components
from tsr_engine.runs.track_video import RunRequest, track_video

SCRIPT = Path(__file__).with_name("ray_batch.py")
COUNT = 4


@pytest.mark.slow
def test_a_batch_survives_the_death_of_a_node(tmp_path: Path) -> None:
    pytest.importorskip("ray", reason="Ray is not installed: pip install 'tsr[cluster]'")
    (tmp_path / "drives").mkdir()
    for number in range(COUNT):
        write_short_drive(tmp_path / "drives" / f"d{number}.mp4", 12 + number)
    done = subprocess.run(
        [sys.executable, str(SCRIPT), str(tmp_path / "drives"), str(tmp_path / "out")],
        capture_output=True, text=True, timeout=400,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "RAY_USAGE_STATS_ENABLED": "0"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    found = json.loads(done.stdout.strip().splitlines()[-1])
    assert found["killed_after"] == [1]
    assert found["states"] == {f"d{number}": ["done", ""] for number in range(COUNT)}
    assert (found["second_call"], found["same"]) == (0, True)
    params = Params().with_settings([("coast_foe_y", 0.5)])
    parts = load_components(params)
    for number in range(COUNT):
        plain = tmp_path / f"{number}.csv"
        track_video(RunRequest(tmp_path / "drives" / f"d{number}.mp4", params, csv=plain), parts)
        rows = plain.read_bytes()
        assert rows.count(b"\n") > 10, "there are signs to be found"
        assert (tmp_path / "out" / f"d{number}" / "tracks.csv").read_bytes() == rows
