"""Replay of the toy drive: the same bits with the same parameters, and the effect of other parameters."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests import toy_pipeline
from tsr_engine.errors import EvidenceError, ModelError, UsageError
from tsr_engine.evidence import EvidenceReader, EvidenceWriter, StoredPixels, differences
from tsr_engine.online.features import FEATURES
from tsr_engine.online.online_detector import OnlineDetectorMaker
from tsr_engine.online.relocalisation import search_extent
from tsr_engine.params import Params
from tsr_engine.params.replayable import changed_parameters
from tsr_engine.pipeline import RECOMPUTED, Components, Models, rescore, start_core
from tsr_engine.protocols import PixelSource, ScoredBox
from tsr_engine.recognition.crops import crop_bounds
from tsr_engine.records import Detections, Event, FloatArray, FrameEvidence
from tsr_engine.runs.replay import ReplayReport, check_models, replay, run_params
from tsr_engine.runs.track_video import RunRequest, track_video
from tsr_engine.tracking import tracker
from tsr_engine.tracking.track import Track


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("replay")
    video = toy_pipeline.write_drive(folder / "drive.mp4", 75)
    track_video(RunRequest(video, toy_pipeline.PARAMS, folder / "run"), toy_pipeline.components())
    video.unlink()
    return folder / "run"


def replay_run(run: Path, *settings: tuple[str, object]) -> tuple[list[FrameEvidence], ReplayReport]:
    params = toy_pipeline.PARAMS.with_settings(settings)
    report = ReplayReport()
    return list(replay(run, params, toy_pipeline.components(params), report=report)), report


def test_same_parameters_give_the_same_bits_in_every_record(run: Path) -> None:
    frames, report = replay_run(run)
    with EvidenceReader(run) as reader:
        stored = list(reader.frames())
    assert len(frames) == len(stored) == 75
    assert sum(len(frame.tracks) for frame in stored) > 60
    assert any(track.relocalisation for frame in stored for track in frame.tracks)
    for new, old in zip(frames, stored, strict=True):
        assert list(differences(new, old, ignore=frozenset({"timings"}))) == []
    assert report.identical == report.frames == 75
    assert report.missing_pixels == report.missing_frames == 0
    assert not report.diff
    assert report.tracks == report.before


def test_a_run_with_older_event_sentences_replays_and_resumes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    video = toy_pipeline.write_drive(tmp_path / "drive.mp4", 40)
    today = tracker.confirmed_event

    def earlier(track: Track, window: int) -> Event:
        event = today(track, window)
        return replace(event, text=f"Track {track.track_id} is confirmed by 3 detections in {track.age + 1} frames.")

    asked = 0

    def stop() -> bool:
        nonlocal asked
        asked += 1
        return asked > 30

    request = RunRequest(video, toy_pipeline.PARAMS, tmp_path / "run")
    with monkeypatch.context() as then:
        then.setattr(tracker, "confirmed_event", earlier)
        track_video(request, toy_pipeline.components(), stop=stop)
    report = track_video(request, toy_pipeline.components())
    assert report.resumed_at is not None
    with EvidenceReader(tmp_path / "run") as reader:
        words = {event.text for _, event in reader.events() if event.kind == "confirmed"}
    _, same = replay_run(tmp_path / "run")
    assert any("in its last" not in text for text in words), words
    assert (same.frames, same.identical, same.first_difference) == (40, 40, "")
    one, other = (Event("died", 1, text, {"missed": missed}) for text, missed in (("It ended.", 3), ("Over.", 4)))
    found = list(differences(one, other, ignore=RECOMPUTED))
    assert found == ["values['missed']: 3 against 4"], "what an event says is compared"


def test_the_online_svm_replays_bit_by_bit_too(tmp_path: Path) -> None:
    strict = [("rejected_measurement", "relocalised"), ("learn_rejected", True), ("position_offset", 2.0)]
    params = toy_pipeline.PARAMS.with_settings(strict)
    maker = OnlineDetectorMaker(np.zeros((0, FEATURES)), np.zeros(0), params.online)
    components = Components(
        toy_pipeline.RedDetector(), Models(toy_pipeline.HueClassifier(), maker), {"classifier": "c" * 64}
    )
    video = toy_pipeline.write_drive(tmp_path / "drive.mp4", 40)
    live = track_video(RunRequest(video, params, tmp_path / "run"), components)
    report = ReplayReport()
    for _ in replay(tmp_path / "run", params, components, report=report):
        pass
    assert sum(track.frames["relocalised"] for track in live.tracks) > 3
    assert (report.identical, report.missing_pixels) == (40, 0), report.first_difference


def test_a_difference_is_detected(run: Path) -> None:
    frames, report = replay_run(run, ("tau", 3.5))
    assert report.identical < 75
    assert report.first_difference.startswith("frame ")
    assert len(frames) == 75


@pytest.mark.parametrize("radius", [1, 20, 40])
def test_pixels_around_every_prediction_are_kept_up_to_keep_radius(run: Path, radius: int) -> None:
    online = toy_pipeline.PARAMS.online.model_copy(update={"search_radius": radius})
    searched = 0
    with EvidenceReader(run) as reader:
        for frame in reader.frames():
            pixels = StoredPixels(frame.width, frame.height, frame.regions)
            for track in frame.tracks:
                if track.prediction is not None:
                    pixels.crop(*search_extent(track.prediction.box, online))
                    searched += 1
            for box in frame.detections.boxes:
                pixels.crop(*crop_bounds(box, toy_pipeline.PARAMS.pipeline.keep_context * 0.9))
            assert pixels.missing == 0, f"frame {frame.ordinal}"
    assert searched > 50


def test_missing_pixels_are_counted(run: Path) -> None:
    _, report = replay_run(run, ("search_radius", 90), ("rejected_measurement", "relocalised"))
    assert report.missing_pixels > 1000
    assert report.missing_frames > 3


def test_lost_tracks(run: Path) -> None:
    _, report = replay_run(run, ("birth_score", 50.0))
    assert report.tracks == []
    assert report.diff.lost == (1, 2)
    assert report.diff.gained == ()


def test_another_lambda_rescores_the_detections(run: Path) -> None:
    frames, _ = replay_run(run, ("prior_lambda", 10.0))
    found = [frame.detections for frame in frames if len(frame.detections)]
    assert found
    for detections in found:
        expected = detections.raw_scores + (detections.prior - 0.5) * 10.0
        assert np.array_equal(detections.scores, expected)
    without, _ = replay_run(run, ("use_prior", False))
    assert all(np.array_equal(f.detections.scores, f.detections.raw_scores) for f in without)


def test_rescoring_by_hand() -> None:
    boxes = np.arange(12, dtype=np.float64).reshape(3, 4)
    stored = Detections(boxes, np.array([1.0, 2.0, 0.0]), np.array([1.0, 0.0, 0.5]), np.zeros(3))
    new = rescore(stored, 4.0)
    assert new.scores.tolist() == [3.0, 0.0, 0.0]
    assert new.raw_scores.tolist() == [1.0, 2.0, 0.0]
    assert np.array_equal(new.boxes, boxes)


def test_parameters_of_unrepeated_steps_cannot_be_changed(run: Path) -> None:
    for name, value in (("min_width", 20.0), ("use_camera_shift", False)):
        with pytest.raises(UsageError, match=name):
            replay_run(run, (name, value))


def test_a_focus_that_a_run_has_not_estimated_must_be_named(tmp_path: Path) -> None:
    """A new run with looming motion would estimate it from the video, which a replay lacks."""
    paper = toy_pipeline.PARAMS.with_settings([("motion", "paper"), ("coast_foe_y", None)])
    video = toy_pipeline.write_drive(tmp_path / "drive.mp4", 6)
    track_video(RunRequest(video, paper, tmp_path / "run"), toy_pipeline.components(paper))
    looming = paper.with_settings([("motion", "looming")])
    with pytest.raises(UsageError, match="Set coast_foe_y to the value that `tsr calibrate` finds"):
        list(replay(tmp_path / "run", looming, toy_pipeline.components(looming)))
    named = looming.with_settings([("coast_foe_y", 0.4)])
    assert len(list(replay(tmp_path / "run", named, toy_pipeline.components(named)))) == 6


def test_a_run_without_pixels_cannot_be_replayed(run: Path, tmp_path: Path) -> None:
    from dataclasses import replace

    with EvidenceReader(run) as reader:
        header = replace(reader.header, keep_pixels=False)
        with EvidenceWriter.create(tmp_path / "bare", header) as writer:
            for frame in reader.frames(stop=5):
                writer.append(frame)
    with pytest.raises(EvidenceError, match="no pixels"):
        replay_run(tmp_path / "bare")


def test_parameters_round_trip_through_the_header(run: Path) -> None:
    with EvidenceReader(run) as reader:
        assert run_params(reader) == toy_pipeline.PARAMS
    assert changed_parameters(toy_pipeline.PARAMS, Params.preset("paper").with_settings([("tau", 3.0)])) != []
    assert changed_parameters(toy_pipeline.PARAMS, toy_pipeline.PARAMS) == []


def test_other_models_are_refused(run: Path) -> None:
    other = Components(toy_pipeline.RedDetector(), toy_pipeline.components().parts, {"classifier": "d" * 64})
    with EvidenceReader(run) as reader:
        check_models(reader, toy_pipeline.components(), toy_pipeline.PARAMS)
        with pytest.raises(ModelError, match="another classifier"):
            check_models(reader, other, toy_pipeline.PARAMS)


def test_a_replay_may_use_another_reader(run: Path) -> None:
    ours = toy_pipeline.components()
    both = replace(ours, models={**ours.models, "network_classifier": "e" * 64})
    with EvidenceReader(run) as reader:
        with pytest.raises(ModelError, match="another network_classifier .expected none"):
            check_models(reader, both, toy_pipeline.PARAMS)
        for choice in ("network", "classifier"):
            check_models(reader, both, toy_pipeline.PARAMS.with_settings([("reader", choice)]))
        other = replace(ours, models={"classifier": "d" * 64})
        with pytest.raises(ModelError, match="another classifier"):
            check_models(reader, other, toy_pipeline.PARAMS.with_settings([("reader", "classifier")]))


def test_another_detector_matters_for_window_rescoring(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A run with another detector did not rescore, so its replay does not either."""
    ours = toy_pipeline.components()

    def look(pixels: PixelSource, box: FloatArray) -> ScoredBox | None:
        raise AssertionError("nothing is replayed here")

    parts = replace(ours.parts, window_scorer=look)
    other = replace(ours, parts=parts, models=dict(ours.models) | {"detector": "e" * 64})
    blind = toy_pipeline.PARAMS.with_settings([("rescore_windows", False)])
    with EvidenceReader(run) as reader:
        check_models(reader, other, toy_pipeline.PARAMS)
        assert start_core(reader, toy_pipeline.PARAMS, parts)._models.window_scorer is None
        header = reader.header
        named = replace(header, models=dict(header.models) | {"detector": "f" * 64})
        monkeypatch.setattr(reader, "header", named)
        assert start_core(reader, toy_pipeline.PARAMS, parts)._models.window_scorer is look
        check_models(reader, other, blind)
        with pytest.raises(ModelError, match="another detector"):
            check_models(reader, other, toy_pipeline.PARAMS)


def test_leaving_a_stream_early_releases_the_store(run: Path) -> None:
    frames = replay(run, toy_pipeline.PARAMS, toy_pipeline.components())
    next(frames)
    frames.close()  # type: ignore[attr-defined]
    assert len(replay_run(run)[0]) == 75


def test_evidence_older_than_a_parameter_replays_unchanged(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A run without a parameter is older than the parameter; today's default must not apply."""
    younger = {
        "detector": {"beyond_edge", "refine_passes"},
        "gate": {"position_offset"},
        "tracking": {"noise_score", "result_noise", "level_frames", "sure_hits", "sure_score", "open_edges"},
        "pipeline": {"relocalise_after", "rescore_windows", "search_sigmas", "search_size_noise", "reader"},
        "online": {"learn_undetected"},
    }
    with EvidenceReader(run) as reader:
        header = reader.header
        kept = {
            section: {name: value for name, value in values.items() if name not in younger.get(section, ())}
            for section, values in header.parameters.items()
        }
        monkeypatch.setattr(reader, "header", replace(header, parameters=kept))
        params = run_params(reader)
    assert (params.gate.position_offset, params.tracking.result_noise, params.tracking.level_frames) == (0.0, 1.0, 0)
    assert (params.tracking.sure_score, params.tracking.open_edges) == (None, False)
    assert (params.pipeline.relocalise_after, params.pipeline.search_sigmas) == (None, None)
    assert params.pipeline.search_size_noise is None
    assert (params.pipeline.reader, toy_pipeline.PARAMS.pipeline.reader) == ("classifier", "both")
    assert (params.pipeline.rescore_windows, params.tracking.noise_score, params.detector.refine_passes) == (
        False,
        0.0,
        1,
    )
    assert params.online.learn_undetected
    assert params.detector.beyond_edge == 0.08
    assert params.gate.tau == toy_pipeline.PARAMS.gate.tau
    assert toy_pipeline.PARAMS.tracking.result_noise < 1.0
