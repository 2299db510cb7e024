from pathlib import Path

import cv2
import numpy as np
import pytest

from tsr_engine.evaluation.fusion import TrackVotes, evaluate_fusion, track_votes
from tsr_engine.evaluation.plots import plot_fusion
from tsr_engine.io.gtsrb import CropItem
from tsr_engine.params import FusionParams


def track(class_id: int, frames: list[tuple[float, dict[int, float]]]) -> TrackVotes:
    p = np.zeros((len(frames), 43), np.float32)
    for row, (_, votes) in zip(p, frames, strict=True):
        for c, share in votes.items():
            row[c] = share
    return TrackVotes(class_id, np.array([side for side, _ in frames]), p)


# Far frames read class 1, the near one class 2; it outweighs them by scale but not by number.
NARROW = FusionParams(fusion_delta=20.0)
FAR = (16.0, {1: 0.9, 2: 0.1})
NEAR = (48.0, {1: 0.1, 2: 0.9})


def test_rates_by_number_of_frames() -> None:
    report = evaluate_fusion([track(2, [FAR, FAR, NEAR]), track(1, [FAR, FAR, FAR])], NARROW, longest=4)
    assert report.tracks == 2
    assert report.frames == (1, 2, 3, 4)
    assert report.rates["equal"] == (0.5, 0.5, 0.5, 0.5)
    assert report.rates["scale"] == (0.5, 0.5, 1.0, 1.0)
    assert report.rates["clamped"] == (0.5, 0.5, 1.0, 1.0)
    assert report.single == pytest.approx(4 / 6)


def test_crops_above_the_centre_scale_count_less_only_without_clamping() -> None:
    wrong_at_centre, right_and_large = (48.0, {1: 0.6, 2: 0.4}), (100.0, {1: 0.1, 2: 0.9})
    report = evaluate_fusion([track(2, [wrong_at_centre, right_and_large])], NARROW, longest=2)
    assert report.rates["scale"] == (0.0, 0.0)
    assert report.rates["clamped"] == (0.0, 1.0)


def test_no_tracks_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one track"):
        evaluate_fusion([])


def test_votes_come_from_each_frame_of_each_track(tmp_path: Path) -> None:
    class Constant:
        margin = 0.1

        def probabilities(self, crops: list[np.ndarray]) -> np.ndarray:
            return np.array([np.eye(43, dtype=np.float32)[crop.shape[0]] for crop in crops])

    items = []
    for frame, side in ((1, 30), (0, 20)):
        path = tmp_path / f"00004_0000{frame}.png"
        cv2.imwrite(str(path), np.zeros((60, 60, 3), np.uint8))
        items.append(CropItem(path, (10, 10, 10 + side, 10 + side), 7, (7, 4), frame))
    reported: list[tuple[int, int]] = []
    (votes,) = track_votes(items, Constant(), lambda done, total: reported.append((done, total)))
    assert reported == [(1, 1)]
    assert votes.class_id == 7
    assert votes.scales.tolist() == [20.0, 30.0]
    assert votes.probabilities.argmax(1).tolist() == [24, 36]


def test_the_plot_is_an_image_file(tmp_path: Path) -> None:
    report = evaluate_fusion([track(2, [FAR, NEAR])], NARROW, longest=2)
    plot_fusion(report, tmp_path / "fusion.png")
    assert cv2.imread(str(tmp_path / "fusion.png")).shape[1] > 500
    assert report.as_dict()["rates"]["equal"] == list(report.rates["equal"])  # type: ignore[index]
