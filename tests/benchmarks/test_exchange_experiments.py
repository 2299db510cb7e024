"""The reports on exports, recordings and retraining follow from figures and name missed targets."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.corruptions.video import dim, write_changed
from benchmarks.experiment import Data, Result, Skip
from benchmarks.experiments import exports, recordings, retraining
from benchmarks.timing import exports as export_times
from tests import toy_pipeline
from tsr_engine.errors import TsrError
from tsr_engine.io.video import open_video
from tsr_engine.track_table import TrackTable


def _format(**more: Any) -> dict[str, Any]:
    return {
        "format": "coco",
        "seconds": 3.0,
        "cpu_seconds": 2.9,
        "peak_mb": 300,
        "files": 1,
        "mb": 80.6,
        "boxes": 188532,
        **more,
    }


def test_exports_that_break_the_budget_are_named() -> None:
    read = {"read_seconds": 3.6, "read_cpu_seconds": 3.5, "read_peak_mb": 322}
    report = exports.EXPERIMENT.report(Result("exports", figures={"formats": [_format(**read), _format(format="csv")]}))
    assert "| coco | 3.0 s | 2.9 s | 300 MB | 1 | 81 MB | 3.6 s | 3.5 s | 322 MB |" in report
    assert "| csv | 3.0 s | 2.9 s | 300 MB | 1 | 81 MB | - | - | - |" in report
    assert "met by every format. Boxes: 188,532." in report
    slow = [_format(), _format(format="voc", seconds=20.5), _format(format="mot", peak_mb=501)]
    assert "exceeded by voc, mot" in exports.EXPERIMENT.report(Result("exports", figures={"formats": slow}))


def test_a_format_is_measured_in_a_separate_process(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    small = tmp_path / "small.py"
    text = Path(export_times.__file__).read_text(encoding="utf-8")
    small.write_text(text.replace("132_400", "2_000").replace("5_000", "20"), encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(Path(export_times.__file__).parents[2]))
    monkeypatch.setattr(export_times, "__file__", str(small))
    found = export_times.measure_in_new_process("tracks-csv")
    assert found["format"] == "tracks-csv"
    assert found["read_boxes"] == found["boxes"] > 20 * 25
    with pytest.raises(TsrError, match="nonsense"):
        export_times.measure_in_new_process("nonsense")


def _drive(**more: Any) -> dict[str, Any]:
    return {
        "source": "03.mp4, joined to itself",
        "picture": "Copied.",
        "megabytes": 3.91,
        "boxes": 1893,
        "seconds": [0.72, 0.08, 0.1],
        "cpu_seconds": [0.75, 0.1, 0.1],
        "command_seconds": 1.47,
        "command_cpu_seconds": 1.71,
        **more,
    }


def test_a_first_recording_that_takes_too_long_is_named() -> None:
    report = recordings.EXPERIMENT.report(Result("recordings", figures={"drives": [_drive()]}))
    assert "| 3.91 MB, 1,893 boxes | 0.72 s (CPU 0.75 s) | 0.08 to 0.10 s | 1.47 s (CPU 1.71 s) |" in report
    assert "of a process: met." in report
    slow = [_drive(), _drive(source="SH4.mp4, joined", seconds=[2.1, 1.1, 1.2])]
    assert "exceeded by SH4.mp4" in recordings.EXPERIMENT.report(Result("recordings", figures={"drives": slow}))


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, TrackTable]:
    """A toy drive with its exact ground truth, the rows of later frames first."""
    path = toy_pipeline.write_drive(tmp_path_factory.mktemp("drive") / "drive.mp4", 12)
    seen = [(k, box) for k in range(12)[::-1] if (box := toy_pipeline.sign_box(k)) is not None]
    n = len(seen)
    truth = TrackTable(
        np.array([k for k, _ in seen]), np.full(n, 7), np.array([box for _, box in seen]),
        np.full(n, 14), ignore=np.arange(n) == 0,
    )  # fmt: skip
    return path, truth


def test_a_corrected_clip_contains_its_annotation(drive: tuple[Path, TrackTable]) -> None:
    path, truth = drive
    video = retraining.corrected(path, truth)
    (track,) = video.tracks()
    assert (video.frames, video.stop) == (12, 12)
    assert (track.uid, track.label) == ("7", 14)
    assert track.frames.tolist() == sorted(truth.frame.tolist())
    assert np.array_equal(track.boxes, truth.boxes[::-1])
    assert track.ignore is not None
    assert track.ignore.tolist() == [*[False] * (len(truth.frame) - 1), True]


def test_a_dim_camera_films_the_same_frames_darker(drive: tuple[Path, TrackTable], tmp_path: Path) -> None:
    path = write_changed(dim, drive[0], tmp_path / "dim.mp4")
    with open_video(drive[0]) as bright, open_video(path) as dark:
        assert (dark.width, dark.height, dark.rate) == (bright.width, bright.height, Fraction(bright.rate))
        pairs = [(a.picture.mean(), b.picture.mean()) for a, b in zip(bright.frames(), dark.frames(), strict=True)]
    assert len(pairs) == 12
    assert all(0.15 * a < b < 0.3 * a for a, b in pairs)


def _camera(before: float, after: float, found: int = 6) -> dict[str, Any]:
    def figures(ap: float, error: float, signs: int) -> dict[str, Any]:
        fixed = {"ap75": 0.9, "recall_at_0.1": 0.9, "mean_eq7": 0.1, "coverage": 0.9, "false_tracks": 0, "signs": 6}
        return {**fixed, "ap50": ap, "mean_error": error, "signs_detected": signs, "signs_classified": signs}

    gtsdb = {"parent": {"ap50": 0.99, "mean_eq7": 0.05}, "new": {"ap50": 0.98, "mean_eq7": 0.07}}
    return {
        "before": figures(before, 0.1, 6),
        "after": figures(after, 0.08, found),
        "gtsdb": gtsdb,
        "corrected_signs": 4,
    }


def test_gains_and_losses_of_corrections_are_reported() -> None:
    result = Result("retraining", figures={"as filmed": _camera(0.99, 0.99), "dim camera": _camera(0.7, 0.72, 5)})
    result.figures["dim camera"]["after"]["coverage"] = 0.85
    report = retraining.EXPERIMENT.report(result)
    assert "- as filmed: AP does not rise (from 0.9900); mean Eq. 7 of tracks falls by 20.0%." in report
    assert "- dim camera: AP rises by 0.0200 (from 0.7000)" in report
    assert "- dim camera: **tracks cover less** (0.9000 to 0.8500)." in report
    assert "as filmed: **tracks" not in report
    assert "- dim camera: **loses 1 of the signs found before**." in report
    assert "| signs found | 6 of 6 | 6 of 6 | 6 of 6 | 5 of 6 |" in report
    assert "| 150 GTSDB scenes: AP | 0.9900 | 0.9800 | 0.9900 | 0.9800 |" in report
    for camera in result.figures.values():
        camera["gtsdb"] = None
    assert "GTSDB scenes: AP" not in retraining.EXPERIMENT.report(result)


def test_without_clips_retraining_and_recordings_are_skipped_by_name(tmp_path: Path) -> None:
    data = Data(None, None, None, None, tmp_path)
    for one in (retraining, recordings):
        with pytest.raises(Skip, match="`clips`"):
            one.EXPERIMENT.run(data)
