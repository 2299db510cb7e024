"""Data of a run: its boxes after corrections."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from app.compare.annotation import corrected_boxes
from app.errors import Conflict, Invalid, NotFound
from app.exchange.dataset import dataset_of, evidence_source
from app.exchange.frame_rates import exact_rate
from app.exchange.run_sources import run_source
from app.storage.models import Run
from tests.app.exchange.exchange_client import ExchangeClient
from tests.app.toy_home import ToyHome
from tsr_engine.errors import InputError


def test_an_unchanged_run_is_exported_unchanged(read_only_api: ExchangeClient) -> None:
    api = read_only_api
    video = api.dataset().videos[0]
    assert (video.frames, video.first, video.stop, video.rate, video.constant_rate) == (75, 0, 75, 25, True)
    assert video.times is not None
    np.testing.assert_allclose(np.diff(video.times), 0.04)
    boxes = api.server.context.evidence.boxes(api.run_id)
    tracks = api.tracks()
    assert list(tracks) == list(boxes.names) == ["m1", "m2"]
    for number, track in enumerate(tracks.values()):
        of_track = boxes.track == number
        np.testing.assert_array_equal(track.frames, boxes.frame[of_track])
        np.testing.assert_array_equal(track.boxes, boxes.boxes[of_track])
        assert not track.key.any()
        assert ((track.score > 0) & (track.score < 1)).all()
        assert (track.source, track.state, track.labels) == ("engine", "open", None)
    assert video.provenance["edit_revision"] == 0
    assert video.provenance["run"]["id"] == api.run_id


def test_a_corrected_run_is_exported_as_compared(api: ExchangeClient) -> None:
    api.make_corrections()
    tracks = api.tracks()
    context = api.server.context
    wanted = corrected_boxes(context.evidence.boxes(api.run_id), api.documents(), 75)
    for index, key in enumerate(wanted.names):
        if key == "m2":  # rejected: no boxes, but it can be exported by its state
            continue
        of_track = wanted.track == index
        np.testing.assert_array_equal(tracks[key].frames, wanted.frame[of_track])
        np.testing.assert_array_equal(tracks[key].boxes, wanted.boxes[of_track])
    m1, drawn = tracks["m1"], tracks["hdrawn01"]
    assert (m1.label, m1.source, tracks["m2"].state, drawn.source, drawn.label) == (
        13,
        "corrected",
        "rejected",
        "human",
        1,
    )
    assert tracks["m2"].source == "engine", "a verdict alone changes no box"
    assert m1.notes[0][1] == "bent <sign> & co"
    assert m1.frames[m1.key].tolist() == [m1.notes[0][0], m1.notes[0][0] + 2]
    assert drawn.frames[drawn.key].tolist() == [5, 11, 15]
    assert drawn.frames.tolist() == [*range(5, 12), 15]
    assert np.isnan(drawn.score).all()
    assert m1.occluded.any()
    assert api.dataset().videos[0].provenance["edit_revision"] == 9


def test_a_label_of_a_single_box_is_exported(api: ExchangeClient) -> None:
    track = api.tracks()["m1"]
    frame = int(track.frames[10])
    api.edit({"name": "relabel_box", "key": "m1", "frame": frame, "class_id": 3}, {"m1": 0})
    found = api.tracks()["m1"]
    assert found.labels is not None
    assert found.frames[found.labels != found.label].tolist() == [frame]
    assert found.labels[10] == 3


def test_merged_and_split_tracks_keep_their_scores(api: ExchangeClient) -> None:
    before = api.tracks()
    cut = int(before["m1"].frames[20])
    api.edit({"name": "split", "key": "m1", "frame": cut, "new_key": "hsplit01"}, {"m1": 0})
    after = api.tracks()
    assert after["hsplit01"].source == "corrected"
    assert after["hsplit01"].label == before["m1"].label
    joined = np.concatenate([after["m1"].score, after["hsplit01"].score])
    np.testing.assert_array_equal(joined, before["m1"].score)
    api.edit({"name": "delete_track", "key": "m2", "frame": 1}, {"m2": 0})
    assert "m2" not in api.tracks()


def test_a_track_split_after_the_engines_last_frame_keeps_its_class(api: ExchangeClient) -> None:
    before = api.tracks()["m1"]
    last = int(before.frames[-1])
    for revision, (frame, x) in enumerate(((last + 2, 10.0), (last + 6, 14.0))):
        box = [x, 20.0, x + 20, 40.0]
        api.edit({"name": "set_box", "key": "m1", "frame": frame, "box": box}, {"m1": revision})
    api.edit({"name": "split", "key": "m1", "frame": last + 4, "new_key": "hsplit01"}, {"m1": 2})
    after = api.tracks()
    assert before.label >= 0
    assert (after["m1"].label, after["hsplit01"].label) == (before.label, before.label)
    assert after["hsplit01"].frames.tolist() == [last + 6]


def test_data_can_be_read_twice(read_only_api: ExchangeClient) -> None:
    api = read_only_api
    video = api.dataset().videos[0]
    assert [t.uid for t in video.tracks()] == [t.uid for t in video.tracks()]


def test_a_bare_evidence_folder_needs_no_data_folder(tracked_home: ToyHome) -> None:
    bare, with_video = evidence_source(tracked_home.folder), evidence_source(tracked_home.folder, tracked_home.video)
    for source in (bare, with_video):
        assert (source.video.rate, source.video.constant_rate, source.video.frames) == (25, True, 75)
        assert [track.uid for track in source.tracks()] == ["m1", "m2"]
    assert bare.video.path is None
    assert with_video.video.path == tracked_home.video
    with pytest.raises(InputError, match="is not the video"):
        evidence_source(tracked_home.folder, tracked_home.folder / "run.json")


def test_runs_that_cannot_be_exported_are_refused(api: ExchangeClient) -> None:
    context = api.server.context
    with context.database.read() as session:
        source = run_source(session, api.server.settings, api.run_id)
        with pytest.raises(NotFound):
            run_source(session, api.server.settings, "0" * 32)
    with pytest.raises(Invalid, match="Two of the runs belong to drive.mp4"):
        dataset_of([source, source])
    with context.database.write() as session:
        session.get_one(Run, api.run_id).state = "running"
    with context.database.read() as session, pytest.raises(Conflict, match="still running"):
        run_source(session, api.server.settings, api.run_id)


@pytest.mark.parametrize(
    ("pts", "base", "announced", "rate", "constant"),
    [
        ([0, 1, 2, 3], Fraction(1, 25), 25.0, Fraction(25), True),
        ([7, 3010, 6013, 9016], Fraction(1, 90000), 29.97, Fraction(30000, 1001), True),
        ([0, 33, 67, 100, 133, 167], Fraction(1, 1000), 30.0, Fraction(30), True),
        ([0, 33, 67, 200, 233], Fraction(1, 1000), 30.0, Fraction(30), False),
        ([0, 40, 80, 120], Fraction(1, 1000), 30.0, Fraction(25), True),
        ([0, 40, 80], Fraction(1, 1000), None, Fraction(25), True),
        ([5], Fraction(1, 1000), None, None, True),
    ],
)
def test_frame_rates_follow_the_time_stamps(
    pts: list[int], base: Fraction, announced: float | None, rate: Fraction | None, constant: bool
) -> None:
    found = exact_rate(np.array(pts), base, announced)
    assert found[1] is constant
    assert found[0] == rate or (rate is not None and abs(float(found[0] or 0) - float(rate)) < 0.01)
