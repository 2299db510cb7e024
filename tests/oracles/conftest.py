"""Other libraries as judges of our files; they live in an environment of their own, named by TSR_ORACLES."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.exchange.small_datasets import make_label_set
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Track
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.labels import label_name
from tsr_engine.io.video_writer import VideoWriter

WIDTH, HEIGHT, FRAMES = 64, 48, 20
CLASSES = ("stop", "yield", "50 km/h")
SCRIPT = Path(__file__).with_name("run_library.py")
SEPARATE_ENVIRONMENTS = {"label_studio_sdk": "label-studio"}
"""Libraries whose pins clash with the others', and the folder of their environment within the first one."""

Box = tuple[int, str, float, float, float, float]
RunLibrary = Callable[..., Any]


@pytest.fixture(scope="session")
def python() -> Path:
    """The interpreter of the libraries; skips where there is none."""
    named = os.environ.get("TSR_ORACLES")
    if not named:
        pytest.skip("TSR_ORACLES is not set: make oracles")
    return Path(named)


@cache
def _installed(python: Path, library: str) -> bool:
    code = f"import importlib.util, sys; sys.exit(importlib.util.find_spec({library!r}) is None)"
    return subprocess.run([python, "-c", code], timeout=120, check=False).returncode == 0


@pytest.fixture
def run_library(python: Path, tmp_path: Path) -> RunLibrary:
    """Ask a library: ``ask("datumaro", "read", "coco", path)``; skips where it is not installed."""

    def run(library: str, action: str, format: str, path: Path, data: object = None) -> Any:
        interpreter = (
            python.parent.parent / SEPARATE_ENVIRONMENTS[library] / "bin" / "python"
            if library in SEPARATE_ENVIRONMENTS
            else python
        )
        if not interpreter.is_file() or not _installed(interpreter, library):
            pytest.skip(f"{library} is not installed there: make oracles")
        done = subprocess.run(
            [interpreter, SCRIPT, library, action, format, path],
            input=json.dumps(data),
            capture_output=True,
            text=True,
            timeout=280,
            check=False,
            cwd=tmp_path,
            env={**os.environ, "YOLO_CONFIG_DIR": str(tmp_path), "YOLO_OFFLINE": "1", "YOLO_AUTOINSTALL": "0"},
        )
        assert done.returncode == 0, done.stderr[-3000:]
        return json.loads(done.stdout)

    return run


@pytest.fixture(scope="session")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """Two signs, one with a gap, one of them hidden for a while, in a video of 20 frames."""
    clip = tmp_path_factory.mktemp("oracles") / "drive.mp4"
    with VideoWriter(clip, WIDTH, HEIGHT, Fraction(25)) as writer:
        for k in range(FRAMES):
            writer.write(np.full((HEIGHT, WIDTH, 3), 12 * k, dtype=np.uint8))
    first = np.array([3, 4, 5, 6, 9, 10])
    second = np.array([5, 6, 7, 8])
    tracks = (
        Track(
            "m1",
            0,
            first,
            np.array([(4 + 2 * k, 5.25, 20 + 2.5 * k, 21.5) for k in range(6)]),
            np.zeros(6, dtype=np.bool_),
            np.array([False, True, True, False, False, False]),
            np.linspace(0.4, 0.9, 6),
        ),
        Track(
            "h2",
            2,
            second,
            np.array([(40.5, 20 + k * k, 52, 32.75 + k * k) for k in range(4)]),
            np.ones(4, dtype=np.bool_),
            np.zeros(4, dtype=np.bool_),
            np.full(4, np.nan),
        ),
    )
    video = DatasetVideo(
        "drive.mp4",
        "c" * 64,
        WIDTH,
        HEIGHT,
        FRAMES,
        Fraction(25),
        np.arange(FRAMES) / 25,
        True,
        lambda: iter(tracks),
        clip,
        0,
        FRAMES,
    )
    return Dataset(make_label_set(*CLASSES), (video,))


def target(dataset: Dataset, **switches: str) -> ImportTarget:
    """An import onto the video of the data set."""
    return ImportTarget(dataset.videos[0], dataset.labels, switches)


def boxes_of(dataset: Dataset) -> list[Box]:
    """All boxes, sorted."""
    return sorted(
        (frame, label_name(dataset.labels, track.label), *box)
        for track in dataset.videos[0].tracks()
        for frame, box in zip(track.frames.tolist(), track.boxes.tolist(), strict=True)
    )


def assert_same_boxes(expected: list[Box], found: list[Any], px: float) -> None:
    """Both have the same boxes of the same classes in the same frames, edges within ``px``."""
    others = sorted(tuple(box[:6]) for box in found)
    assert [(frame, name) for frame, name, *_ in others] == [(frame, name) for frame, name, *_ in expected]
    for one, other in zip(expected, others, strict=True):
        assert np.abs(np.subtract(one[2:], other[2:])).max() <= px, (one, other)
