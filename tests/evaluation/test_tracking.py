"""Tracking figures on tables small enough to count by hand, and the readers."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tsr_engine.errors import InputError
from tsr_engine.evaluation.plots import plot_errors
from tsr_engine.evaluation.track_tables import read_clip_truth, read_mot_truth, read_results
from tsr_engine.evaluation.tracking import BINS, evaluate_video, summarise
from tsr_engine.track_table import TrackTable

SIGN = np.array([100.0, 100.0, 140.0, 140.0])


def truth(*rows: tuple[int, int, np.ndarray, int, bool]) -> TrackTable:
    return TrackTable(
        np.array([r[0] for r in rows]),
        np.array([r[1] for r in rows]),
        np.array([r[2] for r in rows]),
        np.array([r[3] for r in rows]),
        ignore=np.array([r[4] for r in rows]),
    )


def results(*rows: tuple[int, int, np.ndarray, int]) -> TrackTable:
    return TrackTable.of_rows((f, t, b, c, 1.0, "detected") for f, t, b, c in rows)


def shifted_right(box: np.ndarray, px: float) -> np.ndarray:
    return box + np.array([px, 0.0, px, 0.0])


def test_counts_by_hand() -> None:
    """One sign over ten frames: track 1 in frames 1-3, track 2 in 6-9 with the right final class; one false track."""
    signs = truth(*[(f, 5, SIGN, 14, False) for f in range(10)])
    rows = [(f, 1, shifted_right(SIGN, 4), 13) for f in (1, 2, 3)] + [(f, 2, SIGN, 14) for f in (6, 7, 8, 9)]
    rows += [(f, 3, shifted_right(SIGN, 300), 2) for f in (4, 5)]
    report = evaluate_video("v", signs, results(*rows), 10)
    (sign,) = report.signs
    assert (sign.frames, sign.covered, sign.ids, sign.switches, sign.fragments) == (10, 7, (1, 2), 1, 1)
    assert sign.predicted_class == 14
    assert (report.tracks, report.false_tracks, report.false_rows) == (3, (3,), 2)
    s = summarise([report])
    assert (s.signs, s.signs_detected, s.signs_classified, s.false_tracks) == (1, 1, 1, 1)
    assert s.coverage == pytest.approx(0.7)
    assert s.ids_per_sign == pytest.approx(2.0)
    assert s.false_positives_per_frame == pytest.approx(0.2)
    # Eq. 7: three rows lose 4 of 40 px, four are exact.
    assert s.mean_error == pytest.approx(3 * 0.1 / 7)
    assert s.mean_error_any_width == s.mean_error
    # The three uncovered frames count with the full error.
    assert s.mean_error_overall == pytest.approx((3 * 0.1 + 3) / 10)
    assert s.median_error == pytest.approx(0.0)
    assert len(s.histogram) == BINS
    assert sum(s.histogram) == 7
    assert s.histogram[0] == 4


def test_eq7_uses_the_frames_of_coverage() -> None:
    """A sign grows from 16 px: its box misses a quarter until it is 20 px wide, then a tenth."""
    narrow, wide = np.array([100.0, 100.0, 116.0, 116.0]), np.array([100.0, 100.0, 120.0, 120.0])
    signs = truth(
        (0, 5, narrow, 14, False), (1, 5, narrow, 14, False), (2, 5, wide, 14, False), (3, 5, wide, 14, False)
    )
    rows = results(
        (0, 1, shifted_right(narrow, 4), 14), (1, 1, shifted_right(narrow, 4), 14), (2, 1, shifted_right(wide, 2), 14)
    )
    report = evaluate_video("v", signs, rows, 4)
    assert report.narrow_errors == pytest.approx((0.25, 0.25))
    assert report.matched == ((2, 5),)
    s = summarise([report])
    assert s.coverage == pytest.approx(0.5)
    assert s.mean_error == pytest.approx(0.1)
    assert s.mean_error_overall == pytest.approx((0.1 + 1) / 2)
    assert s.mean_error_any_width == pytest.approx((0.25 + 0.25 + 0.1) / 3)
    assert s.mean_error_followed == pytest.approx(0.1)
    assert summarise([evaluate_video("v", signs, rows, 4, min_width=16.0)]).mean_error == s.mean_error_any_width


def test_ignored_ground_truth_does_not_count() -> None:
    small = np.array([110.0, 110.0, 130.0, 130.0])
    signs = truth((0, 1, SIGN, 14, True), (1, 1, SIGN, 14, True))
    # A small box wholly inside an ignored one overlaps it by its own area; one half outside does not.
    report = evaluate_video(
        "v", signs, results((0, 7, SIGN, 1), (1, 8, small, 1), (1, 9, shifted_right(small, 25), 1)), 2
    )
    assert report.signs == ()
    assert report.errors == ()
    assert (report.false_tracks, report.false_rows) == ((9,), 1)
    assert summarise([report]).coverage is None


def test_counted_ground_truth_wins_over_ignored() -> None:
    signs = truth((0, 1, SIGN, 14, False), (0, 2, shifted_right(SIGN, 10), -1, True))
    report = evaluate_video("v", signs, results((0, 1, shifted_right(SIGN, 8), 14)), 1)
    assert report.signs[0].covered == 1


def test_small_signs_match_but_are_not_required() -> None:
    small = np.array([10.0, 10.0, 28.0, 28.0])
    signs = truth((0, 1, small, 14, False), (1, 1, SIGN, 14, False))
    report = evaluate_video("v", signs, results((0, 1, small, 14)), 2)
    assert (report.signs[0].frames, report.signs[0].covered) == (1, 0)
    assert report.signs[0].ids == (1,)
    assert report.false_rows == 0


def test_the_id_of_the_last_frame_is_kept_while_it_overlaps() -> None:
    signs = truth((0, 1, SIGN, 14, False), (1, 1, SIGN, 14, False))
    report = evaluate_video(
        "v", signs, results((0, 1, SIGN, 14), (1, 1, shifted_right(SIGN, 8), 14), (1, 2, SIGN, 14)), 2
    )
    assert report.signs[0].switches == 0
    assert report.false_rows == 1


def test_drift_raises_the_followed_error() -> None:
    signs = truth(*[(f, 1, SIGN, 14, False) for f in range(4)])
    rows = [(0, 1, SIGN, 14), (1, 1, SIGN, 14), (2, 1, SIGN, 14), (3, 1, shifted_right(SIGN, 30), 14)]
    s = summarise([evaluate_video("v", signs, results(*rows), 4)])
    assert s.mean_error == pytest.approx(0.0)
    assert s.mean_error_followed == pytest.approx(0.75 / 4)


def test_figures_without_results_and_without_signs() -> None:
    signs = truth((0, 1, SIGN, 14, False))
    nothing = TrackTable.of_rows([])
    s = summarise([evaluate_video("v", signs, nothing, 1)])
    assert (s.signs, s.signs_detected, s.detection_rate, s.coverage) == (1, 0, 0.0, 0.0)
    assert s.mean_error is None
    empty = summarise([])
    assert empty.detection_rate is None
    assert json.loads(json.dumps(empty.as_dict()))["frames"] == 0


def test_means_by_source() -> None:
    signs = truth((0, 1, SIGN, 14, False), (1, 1, SIGN, 14, False))
    rows = TrackTable.of_rows(
        [(0, 1, SIGN, 14, 1.0, "detected"), (1, 1, shifted_right(SIGN, 10), 14, 0.5, "predicted")]
    )
    s = summarise([evaluate_video("v", signs, rows, 2)])
    assert s.mean_error_by_source == pytest.approx({"detected": 0.0, "predicted": 0.25})


def test_plot_is_a_png(tmp_path: Path) -> None:
    signs = truth((0, 1, SIGN, 14, False))
    s = summarise([evaluate_video("v", signs, results((0, 1, shifted_right(SIGN, 4), 14)), 1)])
    plot_errors({"KF": s, "none": summarise([])}, tmp_path / "hist.png")
    assert (tmp_path / "hist.png").read_bytes().startswith(b"\x89PNG")


class TestReaders:
    def test_clip_ground_truth_is_read(self, tmp_path: Path) -> None:
        path = tmp_path / "clip.csv"
        path.write_text(
            "frame,track_id,x1,y1,x2,y2,class_id,visibility,ignore\n0,1,10,20,30.5,44,14,1,0\n3,2,1,2,3,4,-1,0.4,1\n"
        )
        t = read_clip_truth(path)
        assert t.frame.tolist() == [0, 3]
        assert t.boxes[0].tolist() == [10, 20, 30.5, 44]
        assert t.class_id.tolist() == [14, -1]
        assert t.ignore.tolist() == [False, True]
        assert t.visibility.tolist() == [1.0, 0.4]

    def test_mot_truth_counts_frames_from_zero_and_gives_edges(self, tmp_path: Path) -> None:
        path = tmp_path / "gt.txt"
        path.write_text("1,4,10.5,20,30,40,1,14,0.9\n")
        t = read_mot_truth(path)
        assert t.frame.tolist() == [0]
        assert t.boxes.tolist() == [[10.5, 20.0, 40.5, 60.0]]
        assert t.class_id.tolist() == [14]
        assert not t.ignore[0]

    def test_results_are_read(self, tmp_path: Path) -> None:
        path = tmp_path / "out.csv"
        path.write_text("frame,track_id,x1,y1,x2,y2,class_id,score,source\n2,1,1,2,30,40,14,1.5,relocalised\n")
        r = read_results(path)
        assert (r.frame.tolist(), r.track.tolist(), r.source_words()) == ([2], [1], ["relocalised"])
        assert r.score.tolist() == [1.5]

    def test_empty_results_are_read(self, tmp_path: Path) -> None:
        path = tmp_path / "out.csv"
        path.write_text("frame,track_id,x1,y1,x2,y2,class_id,score,source\n")
        assert read_results(path).boxes.shape == (0, 4)

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("frame,track_id\n", "x1"),
            (
                "frame,track_id,x1,y1,x2,y2,class_id,score,source\n0,1,a,2,3,4,5,6,detected\n",
                "line 2: x1 must be a number, got 'a'",
            ),
            ("frame,track_id,x1,y1,x2,y2,class_id,score,source\n0,1,nan,2,3,4,5,6,detected\n", "finite"),
        ],
    )
    def test_bad_tables_are_refused_by_name(self, tmp_path: Path, text: str, message: str) -> None:
        path = tmp_path / "bad.csv"
        path.write_text(text)
        with pytest.raises(InputError, match=message):
            read_results(path)

    def test_a_missing_file_is_refused(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match=r"none\.csv"):
            read_clip_truth(tmp_path / "none.csv")
        with pytest.raises(InputError, match=r"none\.txt"):
            read_mot_truth(tmp_path / "none.txt")


def test_boxes_are_compared_within_the_picture() -> None:
    """Figures do not depend on whether annotators stopped at the edge."""
    beyond = shifted_right(SIGN, 30)
    shown = results((0, 1, shifted_right(SIGN, 30), 1))
    errors = []
    for box in (beyond, np.minimum(beyond, 160.0)):
        signs, rows = (table.cut(160, 576) for table in (truth((0, 1, box, 1, False)), shown))
        assert rows.boxes[0].tolist() == [130.0, 100.0, 160.0, 140.0]
        same = evaluate_video("v", truth((0, 1, box, 1, False)), shown, 1, size=(160, 576))
        assert same == evaluate_video("v", signs, rows, 1)
        errors.append(summarise([same]).mean_error)
    assert errors == [0.0, 0.0]
    assert shown.boxes[0].tolist() == beyond.tolist()


@pytest.mark.data
def test_real_clip_against_its_own_truth(clips: Path) -> None:
    """Ground truth as a result is perfect, and every sign has one id."""
    t = read_clip_truth(clips / "gt" / "01_076852.csv")
    s = summarise([evaluate_video("01", t, TrackTable(t.frame, t.track, t.boxes, t.class_id), 94)])
    assert (s.signs, s.coverage, s.ids_per_sign, s.false_tracks) == (1, 1.0, 1.0, 0)
    assert s.mean_error == pytest.approx(0.0)
    assert s.classified_of_all == 1.0
