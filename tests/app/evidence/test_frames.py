"""Overlays, lanes of a track, crops and explanations against the engine's records."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest

from app.errors import Invalid, NotFound
from app.evidence.crops import MARGIN
from tests.waiting import wait_until
from tsr_engine.io.video import open_video
from tsr_engine.recognition.crops import cut


def no_picture(video: str, frame: int) -> Any:
    raise AssertionError("the pixels are in evidence")


def first_track(home: Any) -> int:
    with home.reader() as reader:
        return next(track.track_id for track in reader.tracks() if track.confirmed)


def test_overlays_have_every_living_track_and_detection(home: Any) -> None:
    shown = home.evidence.overlays(home.run_id, 0, 74)
    with home.reader() as reader:
        stored = list(reader.frames())
    assert [overlay.frame for overlay in shown] == [frame.ordinal for frame in stored]
    owned = 0
    for overlay, frame in zip(shown, stored, strict=True):
        living = [track for track in frame.tracks if track.state != "dead"]
        assert [track.id for track in overlay.tracks] == [track.track_id for track in living]
        for got, track in zip(overlay.tracks, living, strict=True):
            assert got.box == pytest.approx(track.box.tolist(), abs=0.006)
            assert (got.prediction is None) == (track.prediction is None)
            if track.prediction is not None:
                sigma = np.sqrt(np.diag(track.prediction.covariance))
                assert got.prediction.sigma == pytest.approx(sigma.tolist(), abs=0.006)
            assert (got.gate and got.gate.confident) == (track.gate and track.gate.confident)
            assert (got.relocalisation is None) == (track.relocalisation is None)
            assert got.class_id == (track.recognition and track.recognition.class_id)
        assert len(overlay.detections) == len(frame.detections)
        owners = {track.detection: track.track_id for track in living if track.detection is not None}
        assert [d.track for d in overlay.detections] == [owners.get(i) for i in range(len(frame.detections))]
        owned += len(owners)
    assert owned > 20
    assert any(track.relocalisation for overlay in shown for track in overlay.tracks)


@pytest.mark.parametrize(("first", "last"), [(5, 4), (0, 256)])
def test_windows_that_are_empty_or_too_long_are_refused(home: Any, first: int, last: int) -> None:
    with pytest.raises(Invalid, match="1 to 256 frames"):
        home.evidence.overlays(home.run_id, first, last)


def test_a_window_beyond_the_end_has_the_existing_frames(home: Any) -> None:
    assert [overlay.frame for overlay in home.evidence.overlays(home.run_id, 73, 200)] == [73, 74]


def test_a_lane_has_one_entry_per_frame_and_null_without_a_step(home: Any) -> None:
    track = first_track(home)
    lane = home.evidence.track(home.run_id, track)
    with home.reader() as reader:
        records = [(k, t) for k, t in reader.track(track) if t.state != "dead"]
        events = [(k, e.kind, e.text) for k, e in reader.events(track_id=track)]
    assert lane.frame == [k for k, _ in records]
    assert lane.tau == 3.0
    for i, (_, record) in enumerate(records):
        gate, seen = record.gate, record.recognition
        assert (lane.l_positive[i] is None) == (gate is None)
        if gate is not None:
            assert lane.l_positive[i] == pytest.approx(gate.l_positive, abs=1e-4)
            assert lane.confident[i] is gate.confident
            floored = max(lane.symmetry_magnitude[i], lane.symmetry_floor)
            assert lane.symmetry[i] == pytest.approx(1 / floored, rel=1e-3), "as the page says"
        if seen is not None:
            assert lane.top[i] == int(np.argmax(seen.probabilities))
            assert lane.votes[i] == pytest.approx((seen.votes / seen.votes.sum())[lane.classes].tolist(), abs=1e-4)
        assert lane.learned[i] == sum(s.transform == "learned" for s in record.samples)
        assert (lane.raw_score[i] is None) == (record.detection is None)
    assert lane.classes[0] == records[-1][1].recognition.class_id
    assert len(lane.classes) <= 6
    assert [(e.frame, e.kind, e.text) for e in lane.events] == events


def test_an_unknown_track_is_refused(home: Any) -> None:
    with pytest.raises(NotFound, match="no track 999"):
        home.evidence.track(home.run_id, 999)


def test_a_crop_has_the_pixels_of_the_video(home: Any) -> None:
    track = first_track(home)
    with home.reader() as reader:
        frame, record = next((k, t) for k, t in reader.track(track) if k >= 20 and t.state != "dead")
    with open_video(home.video) as video:
        picture = video.read(frame).picture
    expected = cut(picture, record.box, MARGIN)
    side = max(expected.shape[:2])
    code = home.pixels.crop(home.run_id, track, frame, side, "result", no_picture)
    assert np.array_equal(cv2.imdecode(np.frombuffer(code, np.uint8), cv2.IMREAD_COLOR), expected)
    larger = home.pixels.crop(home.run_id, track, frame, 200, "result", no_picture)
    assert max(cv2.imdecode(np.frombuffer(larger, np.uint8), cv2.IMREAD_COLOR).shape) == 200


def test_without_stored_pixels_the_video_is_read(home: Any, tmp_path: Any) -> None:
    from dataclasses import replace

    from tsr_engine.evidence import EvidenceWriter

    track, bare = first_track(home), home.add_run()
    with home.reader() as reader:
        with EvidenceWriter.create(
            home.settings.home / "runs" / bare, replace(reader.header, keep_pixels=False)
        ) as writer:
            for evidence in reader.frames():
                writer.append(evidence)
        frame = next(k for k, t in reader.track(track) if k >= 20)
    requests = []

    def picture(video: str, ordinal: int) -> Any:
        requests.append((video, ordinal))
        with open_video(home.video) as file:
            return file.read(ordinal).picture

    assert home.pixels.crop(bare, track, frame, 64, "result", picture) == home.pixels.crop(
        home.run_id, track, frame, 64, "result", no_picture
    )
    assert requests == [(home.video_id, frame)]
    with home.database.write() as session:
        from app.storage.models import Run

        session.delete(session.get(Run, bare))


def test_an_explanation_reproduces_the_stored_verdict(home: Any) -> None:
    with home.reader() as reader:
        tracks = [track.track_id for track in reader.tracks() if track.confirmed]
    compared = 0
    for track in tracks:
        lane = home.evidence.track(home.run_id, track)
        for frame, stored, distance, magnitude in zip(
            lane.frame, lane.l_positive, lane.hash_distance, lane.symmetry_magnitude, strict=True
        ):
            if stored is None:
                continue
            found = home.pixels.explain(home.run_id, track, frame)
            assert (found.l_positive, found.hash.distance, found.symmetry.magnitude) == (stored, distance, magnitude)
            assert (int(found.hash.crop, 16) ^ int(found.hash.mean, 16)).bit_count() == found.hash.distance
            width, height = found.symmetry.size
            for x1, y1, x2, y2, weight in found.symmetry.matches:
                assert 0 <= min(x1, x2) <= max(x1, x2) <= width
                assert 0 <= min(y1, y2) <= max(y1, y2) <= height
                assert 0 < weight <= 1
            assert (found.symmetry.axis is None) == (found.symmetry.magnitude == 0)
            compared += 1
    assert compared > 30


def test_a_frame_without_a_verdict_has_no_explanation(home: Any) -> None:
    track = first_track(home)
    birth = home.evidence.track(home.run_id, track).frame[0]
    for frame in (birth, 75, 2**31 - 2):  # the run ends at 74
        with pytest.raises(NotFound, match=f"gave no verdict on track {track} in frame {frame}"):
            home.pixels.explain(home.run_id, track, frame)


@pytest.mark.parametrize("tau", [0.5, 3.0, 8.0, 1e6])
def test_flips_are_the_changed_verdicts(home: Any, tau: float) -> None:
    flips = home.evidence.flips(home.run_id, tau)
    expected: dict[int, list[int]] = {}
    verdicts = 0
    with home.reader() as reader:
        for known in (t for t in reader.tracks() if t.confirmed):
            shown = [(k, t.gate) for k, t in reader.track(known.track_id) if t.gate and k <= known.last_frame]
            verdicts += len(shown)
            turned = [k for k, gate in shown if (gate.l_positive < tau) != gate.confident]
            if turned:
                expected[known.track_id] = turned
    assert flips.verdicts == verdicts
    assert {t.id: (t.flips, t.frame) for t in flips.tracks} == {i: (len(f), f[0]) for i, f in expected.items()}
    assert flips.to_confident + flips.to_rejected == sum(map(len, expected.values()))
    assert flips.run_tau == 3.0
    if tau < 3:
        assert flips.to_confident == 0 < flips.to_rejected
    if tau == 1e6:
        assert flips.to_rejected == 0 < flips.to_confident


def test_the_explaining_process_restarts_after_a_kill(home: Any) -> None:
    track = first_track(home)
    lane = home.evidence.track(home.run_id, track)
    frame = next(k for k, value in zip(lane.frame, lane.l_positive, strict=True) if value is not None)
    before = home.pixels.explain(home.run_id, track, frame)
    home.pixels.explainer.process.kill()
    assert home.pixels.explain(home.run_id, track, frame) == before


def test_the_idle_explaining_process_ends(home: Any) -> None:
    from app.evidence.explainer import Explainer, ExplainRequest

    asker = Explainer(idle=0.1)
    folder = str(home.folder)
    assert asker.explain(ExplainRequest(folder, folder, "", 999, 20)) is None
    wait_until(lambda: asker.process is None)
    asker.close()


def test_an_error_of_the_explaining_process_is_one_sentence(home: Any, tmp_path: Any) -> None:
    from app.evidence.explainer import Explainer, ExplainRequest
    from tsr_engine.errors import EvidenceError

    asker = Explainer()
    with pytest.raises(EvidenceError, match="is no evidence folder"):
        asker.explain(ExplainRequest(str(tmp_path), str(tmp_path), "", 1, 1))
    asker.close()
