"""The experiments on clips: result rows, cached reports, tables."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.cache import Cache
from benchmarks.experiment import Data, Result, Skip
from benchmarks.experiments import ablation_rows, ablations, misses, stress
from benchmarks.reporting import paper_figures as paper
from benchmarks.reporting.against_paper import shortfalls, sign_notes, tables
from benchmarks.reporting.contact_sheet import Cell, cut_square, write_sheet
from benchmarks.reporting.error_sheet import draw_error_sheet, largest
from benchmarks.videos.approaches import read_approaches
from benchmarks.videos.stored_detections import AnnotatedVideo, DetectedVideo, detect_videos
from benchmarks.videos.tracked_clips import PAPER_KF, reports_of, track_together, with_other_inset
from tests import toy_pipeline
from tsr_engine.evaluation.track_tables import read_results, result_table
from tsr_engine.evaluation.tracking import SignReport, VideoReport, summarise
from tsr_engine.geometry.boxes import to_cxcywh
from tsr_engine.io.gtsdb import Scene
from tsr_engine.params import PRESETS, Params
from tsr_engine.runs.track_video import RunRequest, track_video
from tsr_engine.track_table import TrackTable


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return toy_pipeline.write_drive(tmp_path_factory.mktemp("drive") / "drive.mp4", 24)


def _truth(frames: int) -> TrackTable:
    rows = [(k, toy_pipeline.sign_box(k)) for k in range(frames)]
    seen = [(k, box) for k, box in rows if box is not None]
    n = len(seen)
    return TrackTable(
        np.array([k for k, _ in seen]), np.ones(n, np.int64), np.array([box for _, box in seen]),
        np.zeros(n, np.int64),
    )  # fmt: skip


def _seen(drive: Path, folder: Path) -> DetectedVideo:
    """The toy drive as detected by the toy detector, through the evidence of a run."""
    return next(
        detect_videos(
            [AnnotatedVideo("drive", "", drive, _truth(24))], folder, toy_pipeline.components(Params.preset("default"))
        )
    )


def test_tracking_on_shared_detections_gives_the_rows_of_a_run(drive: Path, tmp_path: Path) -> None:
    rows = {
        "shipped": toy_pipeline.PARAMS,
        "alone": toy_pipeline.PARAMS.with_settings([("use_online", False), ("tau", 0.5)]),
        "still": toy_pipeline.PARAMS.with_settings([("use_camera_shift", False)]),
    }
    parts = {name: toy_pipeline.components(params) for name, params in rows.items()}
    together = track_together(_seen(drive, tmp_path / "kept"), rows, parts)
    for name, params in rows.items():
        alone = tmp_path / f"{name}.csv"
        track_video(RunRequest(drive, params, csv=alone), toy_pipeline.components(params))
        expected, found = read_results(alone), result_table(together[name].rows)
        assert together[name].frames == 24
        assert len(found.frame) == len(expected.frame) > 10
        np.testing.assert_array_equal(found.frame, expected.frame)
        np.testing.assert_allclose(found.boxes, expected.boxes, atol=1e-9)
        np.testing.assert_array_equal(found.class_id, expected.class_id)
        assert found.source_words() == expected.source_words()
        assert together[name].stages["detect"] > 0
    other = toy_pipeline.PARAMS.with_settings([("min_width", 30.0)])
    seen = _seen(drive, tmp_path / "kept")
    with pytest.raises(ValueError, match="min_width"):
        track_together(seen, {"other": other}, {"other": toy_pipeline.components(other)})


def test_stored_boxes_are_refined_as_in_the_detector() -> None:
    shipped, paper_way = Params.preset("default"), Params.preset("paper")
    loose = np.array([[100.0, 80, 140, 130], [10, 20, 30, 44]])
    tight = with_other_inset(loose, paper_way, shipped, 720, 576)
    np.testing.assert_allclose(
        to_cxcywh(tight)[:, 2], [40 * shipped.detector.inset_width, 20 * shipped.detector.inset_width]
    )
    np.testing.assert_allclose(
        to_cxcywh(tight)[:, 1], [105 - shipped.detector.inset_rise * 50, 32 - shipped.detector.inset_rise * 24]
    )
    np.testing.assert_allclose(with_other_inset(tight, shipped, paper_way, 720, 576), loose)


def test_a_cached_report_is_used_while_nothing_changed(drive: Path, tmp_path: Path) -> None:
    cache, video = Cache(tmp_path / "kept"), AnnotatedVideo("drive", "", drive, _truth(24))
    detected = []

    def detect() -> DetectedVideo:
        detected.append(video)
        return _seen(drive, tmp_path)

    def report(video: AnnotatedVideo, params: Params) -> tuple[VideoReport, Any]:
        components = {"a": toy_pipeline.components(params)}
        return reports_of("drive", video, detect, {"a": params}, components, cache)["a"]

    first = report(video, toy_pipeline.PARAMS)
    assert first[0].errors
    assert report(video, toy_pipeline.PARAMS) == first
    assert len(detected) == 1
    report(video, toy_pipeline.PARAMS.with_settings([("tau", 4.0)]))
    report(replace(video, truth=replace(video.truth, boxes=video.truth.boxes + 1)), toy_pipeline.PARAMS)
    assert len(detected) == 3


def test_every_departure_has_one_row() -> None:
    named = [leaf for departure in ablation_rows.DEPARTURES for leaf in departure.leaves]
    assert sorted(named) == sorted(set(named))
    ours, theirs = Params.preset("default").model_dump(), Params.preset("paper").model_dump()
    assert set(named) == {leaf for section, leaf in Params.names() if ours[section][leaf] != theirs[section][leaf]}
    rows = ablation_rows.configurations()
    assert set(ablation_rows.ON_CLIPS) <= set(rows)
    default = Params.preset("default")
    assert rows["default"] == default
    assert rows["paper"] == Params.preset("paper")
    assert all(params != default for name, params in rows.items() if name != "default")
    together = default.with_settings([(leaf, PRESETS["paper"][leaf]) for leaf in named])
    assert together == Params.preset("paper")  # nothing else departs


def _report(name: str, errors: list[float], *, read: int | None = 3, ids: tuple[int, ...] = (1,)) -> VideoReport:
    sign = SignReport(1, 3, 20, len(errors), ids, max(0, len(ids) - 1), 0, read)
    return VideoReport(name, 20, (sign,), tuple((e, "detected") for e in errors), tuple(errors), len(ids), (), 0)


def test_a_change_is_judged_over_the_same_videos() -> None:
    rng = np.random.default_rng(0)
    hard = rng.uniform(0.05, 0.3, 20)
    before = [_report(str(i), [h, h + 0.01]) for i, h in enumerate(hard)]
    after = [_report(str(i), [h + 0.004, h + 0.014]) for i, h in enumerate(hard)]
    found = ablations.paired(before, after, 0)
    assert found is not None
    assert found["change"] == pytest.approx(0.004)
    assert found["low"] == pytest.approx(0.004)  # what is hard in all rows cancels out
    assert found["high"] == pytest.approx(0.004)
    assert ablations.paired(before, [_report(str(i), []) for i in range(20)], 0) is None


def test_the_report_of_ablations_names_better_settings() -> None:
    def part(change: float, width: float, worse_ids: bool = False) -> dict[str, Any]:
        rows: dict[str, Any] = {}
        for name in ablation_rows.configurations():
            own = {"mean_error": 0.1, "coverage": 0.9, "ids_per_sign": 1.0, "false_tracks": 0, "signs_classified": 4}
            own["eq7_change"] = {"change": 0.0, "low": -0.001, "high": 0.001} if name != "default" else None
            rows[name] = own
        rows["tau 19"] |= {
            "mean_error": 0.1 + change,
            "ids_per_sign": 1.1 if worse_ids else 1.0,
            "eq7_change": {"change": change, "low": change - width, "high": change + width},
        }
        return rows

    def reported(judged: dict[str, Any]) -> str:
        figures = {"judged": {"approaches": judged}, "tuned": {"approaches": part(-0.01, 0.001)}}
        return ablations.EXPERIMENT.report(Result("ablations", figures=figures))

    assert "no worse on the judged: tau 19." in reported(part(-0.01, 0.001))
    assert "so `default` stays" in reported(part(0.01, 0.001))
    assert "so `default` stays" in reported(part(-0.01, 0.001, worse_ids=True))
    text = reported(part(-0.01, 0.001))
    for departure in ablation_rows.DEPARTURES:
        assert departure.title in text
    assert "| default | 0.1000 |" in text
    assert "are left out of the tables: boxes without inset" in text  # rows that say nothing are named, not repeated


def test_tables_compare_with_the_paper_and_name_shortfalls() -> None:
    reports = [_report("a", [0.1] * 10), _report("b", [0.2] * 10, read=5, ids=(1, 2)), _report("c", [], ids=())]
    figures = summarise(reports).as_dict() | {"detection_ms": 30.0, "classification_ms": 4.0}
    text = tables({"ours": figures})
    assert "| signs detected | 546 | 582 | 577 | 2 |" in text
    assert "| 93.01 % | 99.14 % | 98.29 % | 66.67 % |" in text
    assert "| 30.0 |" in text
    said = shortfalls(figures, "toys")
    assert "2 of 3 (66.67 %) **falls short of** the paper's 98.29 %" in said
    assert "1 of 2 (50.00 %) **falls short of** the paper's 99.48 %" in said
    assert "0 in 60 frames" in said
    assert "**above**" in said
    notes = sign_notes(reports)
    assert [n["clip"] for n in notes["missed"]] == ["c"]
    assert [(n["clip"], n["read"]) for n in notes["misread"]] == [("b", 5)]
    assert [(n["clip"], n["ids"]) for n in notes["split"]] == [("b", 2)]


def test_the_rates_of_the_paper_follow_from_its_counts() -> None:
    rates = [
        (
            paper.truncated_percent(s.detected, paper.SIGNS),
            paper.truncated_percent(s.classified, s.detected),
            paper.truncated_percent(s.classified, paper.SIGNS),
        )
        for s in paper.SYSTEMS
    ]
    assert rates == [  # as printed in Tables I and II
        ("93.01 %", "98.71 %", "91.82 %"),
        ("99.14 %", "99.82 %", "98.97 %"),
        ("98.29 %", "99.48 %", "97.78 %"),
    ]


def test_scenes_used_for_tuning_are_not_reported(tmp_path: Path) -> None:
    clips = [{"clip": f"00{i}", "stress": "turn", "image": f"{i}.jpg"} for i in range(3)]
    (tmp_path / "clips.json").write_text(json.dumps({"seed": 9, "clips": clips}))
    for clip in clips:
        (tmp_path / clip["clip"]).mkdir()
        (tmp_path / clip["clip"] / "gt.txt").write_text("1,1,10,10,20,20,1,3,1.0\n")
    found = read_approaches(tmp_path, without=["1.jpg"])
    assert sorted(found.videos) == ["000", "002"]
    assert found.stresses == ("turn",)
    assert sorted(read_approaches(tmp_path, each=2).videos) == ["000", "001"]
    with pytest.raises(Skip, match="no clip"):
        read_approaches(tmp_path, without=["0.jpg", "1.jpg", "2.jpg"])
    with pytest.raises(Skip, match="clips.json"):
        read_approaches(tmp_path / "000")


def test_experiments_without_data_are_skipped_by_name(tmp_path: Path) -> None:
    nowhere = Data(None, None, None, None, tmp_path)
    for experiment in (ablations.EXPERIMENT, stress.EXPERIMENT):
        with pytest.raises(Skip, match=r"`(clips|looming)`"):
            experiment.run(nowhere)


def test_misses_are_signs_without_a_confident_detection(tmp_path: Path) -> None:
    boxes = np.array([[10.0, 10, 40, 40], [60, 60, 78, 78], [100, 100, 140, 140]])
    scene = Scene("00001.jpg", tmp_path / "00001.jpg", boxes, np.array([1, 2, 3]))
    detections = np.array([[10.0, 10, 40, 40], [60, 60, 78, 78], [100, 100, 118, 140]])
    seen = misses.SceneDetections(scene, detections, np.array([3.0, 0.5, 4.0]))
    found = misses.misses([seen], threshold=1.0)
    assert [(m["sign"], m["class"]) for m in found] == [(1, 2), (2, 3)]
    assert found[0]["score"] == 0.5
    assert "small" in misses.reason(found[0], contrast=60)
    assert "low contrast" in misses.reason(found[0], contrast=5)
    assert "overlaps by 0.45" in misses.reason(found[1], contrast=60)


def test_errors_are_shown_in_the_frame_with_the_largest_sign(drive: Path, tmp_path: Path) -> None:
    frame, box = largest({3: np.array([0.0, 0, 10, 10]), 7: np.array([0.0, 0, 20, 10]), 9: np.array([5.0, 5, 15, 15])})
    assert frame == 7
    assert box[2] == 20
    nothing: dict[str, list[dict[str, Any]]] = {"missed": [], "misread": [], "false": [], "split": []}
    sheet = tmp_path / "sheet.png"
    sheet.write_bytes(b"an older one")
    draw_error_sheet(sheet, tmp_path, {"drive": (drive, _truth(24))}, nothing)
    assert not sheet.exists()


def test_bars_are_judged_row_by_row() -> None:
    def row(error: float, ids: float = 1.0, coverage: float = 0.9) -> dict[str, Any]:
        return {
            "mean_error": error, "mean_error_any_width": error, "ids_per_sign": ids, "coverage": coverage,
            "signs": 2, "signs_detected": 2,
            "signs_classified": 2, "false_tracks": 0, "frames": 60,
            "notes": {"missed": [], "misread": [], "split": [], "false": []},
        }  # fmt: skip

    same = {"n": 0, "ours": None, "theirs": None, "only_ours": 0, "only_theirs": 0}
    other = {"n": 3, "ours": 0.06, "theirs": 0.08, "only_ours": 2, "only_theirs": 1}

    def reported(default: dict[str, Any]) -> str:
        def rows(changed: dict[str, Any]) -> dict[str, Any]:
            alone = row(0.10) | {"changed": changed}
            return {"default": default, "KF alone": alone, PAPER_KF: row(0.12), "paper": row(0.2)}

        return stress.EXPERIMENT.report(Result("stress", figures={"turn": rows(same), "blur": rows(other)} | {
            "all": rows(other)}))  # fmt: skip

    good = reported(row(0.09))
    assert "met on every row" in good
    assert "worse than `paper`: none" in good
    assert "| blur | 3 | 0.0600 | 0.0800 | 2 | 1 |" in good
    assert "changed no box of a sign on turn." in good
    assert "met on every row" in reported(row(0.10))  # no better than KF alone, but no worse
    bad = reported(row(0.13, ids=1.5, coverage=0.8))
    assert "turn: Eq. 7 0.1300, not below 0.1175" in bad
    assert "turn: Eq. 7 0.1300, above the 0.1000 of KF alone" in bad
    assert "turn: Eq. 7 0.1300, not below 0.1200 of the paper's KF alone" in bad
    assert "turn: 1.500 ids per sign, above 1.05" in bad
    assert "turn: coverage 0.8000 against 0.9000" in bad


def test_a_sheet_shows_the_chosen_errors(tmp_path: Path) -> None:
    picture = np.full((100, 100, 3), 40, np.uint8)
    picture[40:60, 40:60] = (0, 0, 250)
    square = cut_square(picture, (40, 40, 60, 60), 0.5, 40)
    assert square.shape == (40, 40, 3)
    assert square[20, 20, 2] > 240
    assert square[2, 2, 2] < 60
    sheet = tmp_path / "sheet.png"
    write_sheet(sheet, [Cell(str(i), picture, (40, 40, 60, 60)) for i in range(12)])
    assert sheet.stat().st_size > 500
    write_sheet(tmp_path / "empty.png", [])
    assert not (tmp_path / "empty.png").exists()
