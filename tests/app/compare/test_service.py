"""Comparisons of runs, corrected runs and ground truths in a data folder."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from app.compare.annotation import corrected_boxes
from app.compare.service import CompareService
from app.edits.documents import NO_CLASS, OPEN_END, KeyFrame, Segment, TrackDoc
from app.errors import Invalid, NotFound
from app.ground_truths.service import GroundTruthService
from app.storage.models import GroundTruth, TrackDocument
from tests.app import toy_home
from tsr_engine.track_table import TrackTable


def service(home: Any) -> CompareService:
    ground_truths = GroundTruthService(home.database)
    return CompareService(home.database, home.evidence, ground_truths)


def machine() -> TrackTable:
    """Tracks m1 in frames 0..9 and m2 in frames 5..14."""
    frame = np.concatenate([np.arange(10), np.arange(5, 15)])
    track = np.repeat([0, 1], 10)
    boxes = np.stack([frame, frame, frame + 20.0, frame + 20.0], axis=1) + 100.0 * track[:, None]
    order = np.lexsort((track, frame))
    label = np.where(track == 0, 14, 13)
    return TrackTable(
        frame[order], track[order], boxes[order], label[order], source=np.zeros(20, np.int64), names=("m1", "m2")
    )


def boxes_by_frame(table: TrackTable, key: str) -> dict[int, list[float]]:
    if key not in table.names:
        return {}
    rows = np.flatnonzero(table.track == table.names.index(key))
    return dict(zip(table.frame[rows].tolist(), table.boxes[rows].tolist(), strict=True))


def test_unchanged_tracks_are_compared_unchanged() -> None:
    same = corrected_boxes(machine(), {}, 15)
    assert np.array_equal(same.boxes, machine().boxes)
    assert np.array_equal(same.class_id, machine().class_id)


@pytest.mark.parametrize("changes", [{"gone": True}, {"not_a_sign": True}, {"review": "rejected"}])
def test_rejected_tracks_have_no_boxes(changes: dict[str, Any]) -> None:
    document = TrackDoc(key="m1", segments=(Segment(track=1, first=0, last=9),), **changes)
    found = corrected_boxes(machine(), {"m1": document}, 15)
    assert boxes_by_frame(found, "m1") == {}
    assert len(boxes_by_frame(found, "m2")) == 10


def test_corrections_are_applied_to_the_run() -> None:
    merged = TrackDoc(
        key="m1",
        class_id=3,
        segments=(Segment(track=1, first=0, last=6), Segment(track=2, first=7, last=14)),
        keys={
            "3": KeyFrame(box=(0, 0, 5, 5)),
            "8": KeyFrame(outside=True),
            "10": KeyFrame(class_id=5),
            "12": KeyFrame(class_id=NO_CLASS),
        },
    )
    drawn = TrackDoc(
        key="habcdef",
        class_id=7,
        keys={"2": KeyFrame(box=(0, 0, 10, 10), interpolate=True), "4": KeyFrame(box=(20, 0, 30, 10))},
    )
    gone = TrackDoc(key="m2", gone=True, merged_into="m1")
    found = corrected_boxes(machine(), {"m1": merged, "m2": gone, "habcdef": drawn}, 15)
    assert found.names == ("m1", "m2", "habcdef")
    boxes = boxes_by_frame(found, "m1")
    assert sorted(boxes) == [0, 1, 2, 3, 4, 5, 6, 7, 10, 11, 12, 13, 14]
    assert boxes[3] == [0, 0, 5, 5]
    assert boxes[7] == [107, 107, 127, 127]
    assert boxes_by_frame(found, "m2") == {}
    assert boxes_by_frame(found, "habcdef") == {2: [0, 0, 10, 10], 3: [10, 0, 20, 10], 4: [20, 0, 30, 10]}
    rows = np.flatnonzero(found.track == 0)
    labels = dict(zip(found.frame[rows].tolist(), found.class_id[rows].tolist(), strict=True))
    assert labels == dict.fromkeys(boxes, 3) | {10: 5, 12: NO_CLASS}
    sources = dict(zip(found.frame[rows].tolist(), found.source[rows].tolist(), strict=True))
    assert sources == dict.fromkeys(boxes, 0) | {3: -1}
    assert (np.diff(found.frame) >= 0).all()


def test_a_run_against_itself_is_perfect(home: Any) -> None:
    found = service(home).compare(f"run:{home.run_id}", f"annotation:{home.run_id}")
    assert found.figures["precision"].value == found.figures["recall"].value == 1.0
    assert found.figures["eq7"].value == 0.0
    assert (found.first, found.last) == (0, 74)
    assert found.sides["candidate"].name == "Run 1, corrected"


def test_a_far_key_frame_of_an_older_version_is_fast(tmp_path: Any) -> None:
    home = toy_home.make_home(tmp_path)
    try:
        line = {"0": KeyFrame(box=(1, 1, 9, 9), interpolate=True), str(OPEN_END): KeyFrame(box=(1, 1, 9, 9))}
        body = TrackDoc(key="hfar0001", revision=1, keys=line).model_dump(mode="json")
        with home.database.write() as session:
            session.add(TrackDocument(run_id=home.run_id, key="hfar0001", revision=1, document=body))
        found = service(home).compare(f"run:{home.run_id}", f"annotation:{home.run_id}")
        assert found.sides["candidate"].boxes == found.sides["reference"].boxes + 75
        assert (found.first, found.last) == (0, 74)
    finally:
        home.evidence.close()
        home.database.close()


def test_a_correction_shows_against_the_run(tmp_path: Any) -> None:
    home = toy_home.make_home(tmp_path)
    try:
        track = home.evidence.boxes(home.run_id).names[0]
        span = home.evidence.span(home.run_id, int(track[1:]))
        document = TrackDoc(
            key=track, revision=1, gone=True, segments=(Segment(track=int(track[1:]), first=span[0], last=span[1]),)
        )
        drawn = TrackDoc(key="hdrawn01", revision=1, keys={"70": KeyFrame(box=(1, 1, 9, 9))})
        with home.database.write() as session:
            for doc in (document, drawn):
                body = doc.model_dump(mode="json")
                session.add(TrackDocument(run_id=home.run_id, key=doc.key, revision=1, document=body))
        found = service(home).compare(f"annotation:{home.run_id}", f"run:{home.run_id}")
        assert found.sides["reference"].names == {"hdrawn01": "drawn at 70"}
        assert found.sides["candidate"].names == {}
        assert (found.sides["reference"].edited, found.sides["candidate"].edited) == (False, True)
        assert found.figures["false_tracks"].tracks == [track]
        assert found.figures["recall"].tracks == ["hdrawn01"]
        assert found.figures["precision"].value < 1.0
    finally:
        home.evidence.close()
        home.database.close()


def test_only_frames_that_both_have_count(home: Any) -> None:
    from dataclasses import replace

    from tsr_engine.evidence import EvidenceWriter

    part = home.add_run(name="Part", first=20, stop=40)
    with home.reader() as reader:
        header = replace(reader.header, keep_pixels=False)
        with EvidenceWriter.create(home.settings.home / "runs" / part, header) as writer:
            for frame in reader.frames(20, 40):
                writer.append(frame)
    found = service(home).compare(f"run:{home.run_id}", f"run:{part}")
    assert (found.first, found.last) == (20, 39)
    assert found.figures["precision"].value == found.figures["recall"].value == 1.0


def test_invalid_comparisons_are_refused(home: Any) -> None:
    with pytest.raises(NotFound):
        service(home).compare("run:" + "0" * 32, f"run:{home.run_id}")
    with pytest.raises(NotFound):
        service(home).compare(f"run:{home.run_id}", "truth:" + "0" * 32)
    with pytest.raises(Invalid, match="Name a run"):
        service(home).compare("video:1", f"run:{home.run_id}")


def test_a_truth_of_another_video(home: Any) -> None:
    from app.storage.ground_truth_rows import pack
    from app.storage.models import Video

    with home.database.write() as session:
        session.add(Video(id="f" * 64, name="other", path="/other", size=1, state="ready", frames=10, warnings=[]))
        session.flush()
        session.add(GroundTruth(id="e" * 32, video_id="f" * 64, name="t", boxes=pack(np.zeros((0, 9))), count=0))
    with pytest.raises(Invalid, match="different videos"):
        service(home).compare("truth:" + "e" * 32, f"run:{home.run_id}")
