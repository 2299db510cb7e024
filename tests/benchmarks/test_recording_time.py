"""The drives used to measure recordings."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from benchmarks.timing import recordings
from tsr_engine.errors import TsrError
from tsr_engine.io.video_writer import VideoWriter


@pytest.fixture
def clips(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A clip of few and a clip of many bytes, 20 frames each, and one of another size."""
    for name, value in (("FRAMES", 50), ("WIDTH", 64), ("HEIGHT", 48)):
        monkeypatch.setattr(recordings, name, value)
    rng = np.random.default_rng(1)
    for name, width, noise in (("lean", 64, 1), ("fat", 64, 200), ("large", 128, 200)):
        with VideoWriter(tmp_path / f"{name}.mp4", width, 48, Fraction(25)) as writer:
            for _ in range(20):
                writer.write(rng.integers(0, noise, (48, width, 3)).astype(np.uint8))
    return tmp_path


def test_the_smallest_and_the_largest_file_of_a_size_are_chosen(clips: Path) -> None:
    assert recordings.clip_of_kind("copied", clips).name == "lean.mp4"
    assert recordings.clip_of_kind("encoded", clips).name == "fat.mp4"
    with pytest.raises(TsrError, match="no clip of 64x48"):
        recordings.clip_of_kind("copied", clips / "nothing")


def test_a_clip_is_repeated_until_it_is_long_enough(clips: Path) -> None:
    recordings.repeat_clip(clips / "fat.mp4", clips / "joined.mp4", recordings.FRAMES)
    with av.open(clips / "joined.mp4") as container:
        pictures = [(frame.pts, frame.to_ndarray(format="gray")) for frame in container.decode(video=0)]
    times = np.array([pts for pts, _ in pictures])
    assert len(times) == 60
    assert len(set(np.diff(times).tolist())) == 1
    for before, after in zip(pictures[:20], pictures[40:], strict=True):
        assert np.array_equal(before[1], after[1])
