"""Measures the memory to follow a sign backwards through a long video."""

from __future__ import annotations

import tempfile
from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from benchmarks.timing.processes import memory
from tsr_engine.follow import Anchor, FollowerModels, Proposal
from tsr_engine.follow_video import follow_video
from tsr_engine.json_shapes import JsonObject
from tsr_engine.records import FloatArray

_FRAMES, _GROUP = 10_000, 250
_EARLY = 5_000


def flat_memory(parts: FollowerModels, scratch: Path) -> JsonObject:
    """Resident memory after some frames, and after all of a long video.

    Args:
        parts: models of the follower.
        scratch: folder for the video.
    """
    with tempfile.TemporaryDirectory(dir=scratch) as folder:
        path = Path(folder) / "long.mp4"
        box = _write(path)
        early = late = 0.0
        done = 0
        for event in follow_video(path, [Anchor(_FRAMES - 1, box)], parts, direction="backward"):
            done += isinstance(event, Proposal)
            if done == _EARLY:
                early = memory()["rss_mb"]
        late = memory()["rss_mb"]
    return {"frames": done, "group": _GROUP, "early": _EARLY, "early_mb": early, "late_mb": late}


def _write(path: Path) -> FloatArray:
    """Write a video of a static sign in a slowly moving picture; returns its box in the last frame."""
    rng = np.random.default_rng(0)
    wide = np.kron(rng.integers(40, 200, (12, 40, 3)), np.ones((8, 8, 1))).astype(np.uint8)
    sign = np.kron(rng.integers(0, 255, (5, 5, 3)), np.ones((6, 6, 1))).astype(np.uint8)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=Fraction(25))
        stream.width, stream.height, stream.pix_fmt = 160, 96, "yuv420p"
        stream.options = {"preset": "ultrafast", "g": str(_GROUP), "keyint_min": str(_GROUP), "sc_threshold": "0"}
        for k in range(_FRAMES):
            shift = round(60 + 50 * np.sin(k / 120))
            picture = np.ascontiguousarray(wide[:, shift : shift + 160])
            x, y = 65 + round(20 * np.sin(k / 90)), 33 + round(10 * np.cos(k / 70))
            picture[y : y + 30, x : x + 30] = sign
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24")))
        container.mux(stream.encode(None))
    return np.array([x, y, x + 30, y + 30], dtype=np.float64)
