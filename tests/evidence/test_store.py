"""Round trips and resuming of the evidence store."""

from __future__ import annotations

import dataclasses
import math
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.evidence.complete_run import write_complete_run
from tests.evidence.synthetic_evidence import make_frame, make_header, make_track
from tsr_engine.errors import EvidenceError
from tsr_engine.evidence import (
    RESULT_HEADER,
    EvidenceReader,
    EvidenceWriter,
    RunHeader,
    TableEntry,
    VideoIdentity,
    differences,
)
from tsr_engine.evidence.schema import DATABASE
from tsr_engine.params import Params
from tsr_engine.records import Detections, GateVerdict


def test_records_round_trip_bit_by_bit(folder: Path, header: RunHeader) -> None:
    frames = [make_frame(k, tracks=k % 4) for k in range(30)]
    write_complete_run(folder, header, frames)
    with EvidenceReader(folder) as run:
        back = list(run.frames())
        assert len(run) == len(back) == 30
        assert [d for a, b in zip(frames, back, strict=True) for d in differences(a, b)] == []
        assert run.state == "complete"


def test_extreme_numbers_round_trip(folder: Path, header: RunHeader) -> None:
    odd = np.array([-0.0, 0.0, math.nan, 5e-324, 1e308, 3.0, 0.1 + 0.2])
    gate = GateVerdict(-0.0, math.inf, 0.0, math.nan, 2.0, confident=False)
    track = make_track(np.random.default_rng(0), 1, score=-0.0, gate=gate, box=np.array([-0.0, 1.0, math.nan, 2.5]))
    found = Detections(np.tile([-0.0, 5e-324, 0.1 + 0.2, 1e308], (len(odd), 1)), odd, odd[::-1].copy(), odd)
    frame = make_frame(0, detections=found, tracks=(track,), seconds=-0.0, timings={"a": 0.0, "b": -0.0})
    write_complete_run(folder, header, [frame])
    with EvidenceReader(folder) as run:
        assert list(differences(frame, next(run.frames()))) == []


@pytest.mark.parametrize("value", ["9e999", "NULL"])
def test_a_stored_box_that_is_not_finite_is_reported_as_damage(value: str, folder: Path, header: RunHeader) -> None:
    zero = np.zeros(1)
    write_complete_run(
        folder, header, [make_frame(0, detections=Detections(np.array([[0.0, 0.0, 9.0, 9.0]]), zero, zero, zero))]
    )
    with closing(sqlite3.connect(folder / DATABASE)) as connection:
        connection.execute(f"UPDATE detections SET x2 = {value}")
        connection.commit()
    with EvidenceReader(folder) as run, pytest.raises(EvidenceError, match=r"frame 0 is damaged: Detections.boxes"):
        next(run.frames())


def test_an_empty_frame_and_an_empty_run(folder: Path, header: RunHeader) -> None:
    bare = make_frame(7, detections=Detections.empty(), tracks=(), events=(), regions=(), timings={})
    write_complete_run(folder, header, [bare])
    with EvidenceReader(folder) as run:
        assert (run.first_frame, run.last_frame, len(run)) == (7, 7, 1)
        assert list(differences(bare, next(run.frames()))) == []
    write_complete_run(folder.parent / "none", header, [])
    with EvidenceReader(folder.parent / "none") as run:
        assert (run.first_frame, run.last_frame, len(run), run.last_empty_frame()) == (None, None, 0, None)
        assert list(run.frames()) == list(run.tracks()) == list(run.result_rows()) == list(run.events()) == []


def test_ranges_and_frame_table(folder: Path, header: RunHeader) -> None:
    with EvidenceWriter.create(folder, header, chunk=7) as writer:
        for k in range(10, 100):
            writer.append(make_frame(k, tracks=1), TableEntry(k * 512, key=k % 10 == 0, corrupt=k == 33))
    with EvidenceReader(folder) as run:
        assert [f.ordinal for f in run.frames(20, 25)] == [20, 21, 22, 23, 24]
        assert [f.ordinal for f in run.frames(-5, 12)] == [10, 11]
        assert [f.ordinal for f in run.frames(98, 500)] == [98, 99]
        assert next(run.frames(15, pixels=False)).regions == ()
        table = dict(run.frame_table())
        assert table[33] == TableEntry(33 * 512, key=False, corrupt=True)
        assert table[40].key
        assert len(table) == 90


def test_a_track_on_its_own(folder: Path, header: RunHeader) -> None:
    frames = [make_frame(k, tracks=3 if 5 <= k < 90 else 1) for k in range(100)]
    write_complete_run(folder, header, frames)
    with EvidenceReader(folder) as run:
        rows = list(run.track(3))
        assert [k for k, _ in rows] == list(range(5, 90))
        assert [d for k, track in rows for d in differences(frames[k].tracks[2], track)] == []
        assert list(run.track(99)) == []
        assert {k for k, _ in run.events(3, 6, track_id=1)} == {3, 4, 5}
        assert [t.track_id for t in run.tracks(0, 5)] == [1]
        assert [t.track_id for t in run.tracks(89, 90)] == [1, 2, 3]


def test_summaries_and_result_rows(folder: Path, header: RunHeader) -> None:
    rng = np.random.default_rng(0)
    box = np.array([1.006, 2.0, 31.0, 52.0])
    early = make_track(rng, 1).recognition
    assert early is not None
    late = dataclasses.replace(early, class_id=38, share=0.6)
    one = [
        make_track(rng, 1, state="tentative", box=box, score=0.5, source="detected"),
        make_track(
            rng, 1, state="confirmed", box=box, score=0.25, detection=None, source="predicted", recognition=None
        ),
        make_track(rng, 1, state="confirmed", box=box, score=0.125, recognition=late),
        make_track(rng, 1, state="dead", box=box, score=9.0, recognition=None),
    ]
    never = make_track(rng, 2, state="tentative", box=box)
    frames = [make_frame(k, tracks=(one[k], never) if k == 0 else (one[k],)) for k in range(4)]
    write_complete_run(folder, header, frames, chunk=2)
    with EvidenceReader(folder) as run:
        first, second = run.tracks()
        assert (first.first_frame, first.last_frame, first.frames, first.detected_frames) == (0, 2, 3, 2)
        assert (first.confirmed_frame, first.class_id, first.share, first.best_score) == (1, 38, 0.6, 0.5)
        assert first.largest_side == 50.0
        assert not second.confirmed
        assert RESULT_HEADER == "frame,track_id,x1,y1,x2,y2,class_id,score,source"
        assert [row.line() for row in run.result_rows()] == [
            "0,1,1.01,2.00,31.00,52.00,38,0.5000,detected",
            "1,1,1.01,2.00,31.00,52.00,38,0.2500,predicted",
            "2,1,1.01,2.00,31.00,52.00,38,0.1250,relocalised",
        ]
        assert len(list(run.result_rows(confirmed_only=False))) == 4
        assert run.last_empty_frame() == 3
        assert run.last_empty_frame(before=3) is None


def test_resume_equals_an_uninterrupted_run(folder: Path, header: RunHeader) -> None:
    frames = [make_frame(k, tracks=k % 3) for k in range(40)]
    write_complete_run(folder, header, frames, chunk=8)
    other = folder.parent / "resumed"
    writer = EvidenceWriter.create(other, header, chunk=8)
    for evidence in frames[:21]:
        writer.append(evidence)
    writer.close("interrupted", "Ctrl-C.")
    with EvidenceReader(other) as run:
        assert (run.state, run.header.reason) == ("interrupted", "Ctrl-C.")
    with EvidenceWriter.resume(other, header, chunk=8) as writer:
        assert writer.last_frame == 20
        for evidence in frames[21:]:
            writer.append(evidence)
    with EvidenceReader(folder) as a, EvidenceReader(other) as b:
        assert list(differences(list(a.frames()), list(b.frames()))) == []
        assert list(differences(list(a.tracks()), list(b.tracks()))) == []
        assert b.state == "complete"
    assert dump(folder) == dump(other)


def dump(folder: Path) -> list[str]:
    connection = sqlite3.connect(folder / "evidence.sqlite")
    try:
        return sorted(connection.iterdump())
    finally:
        connection.close()


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"video": VideoIdentity("other.mp4", "00" * 32, 12345)}, "video: drive.mp4 against other.mp4"),
        ({"parameters": {"gate": {"tau": 20.0}, "online": {"search_scales": (1.0, 1.1)}}}, "parameter gate.tau: 15.0"),
        ({"models": {"detector": "ee" * 32}}, "model detector"),
        ({"engine_version": "99.0"}, "engine version"),
        ({"keep_pixels": False}, "pixels kept"),
    ],
)
def test_resuming_another_run_is_refused(folder: Path, change: dict[str, Any], named: str) -> None:
    write_complete_run(folder, make_header(), [make_frame(0)])
    with pytest.raises(EvidenceError, match="belongs to another run") as error:
        EvidenceWriter.resume(folder, make_header(**change))
    assert named in str(error.value)
    # The same content with another name is the same video.
    EvidenceWriter.resume(folder, make_header(video=VideoIdentity("moved.mp4", "ab" * 32, 12345))).close()


def test_all_real_parameters_fit_into_the_header(folder: Path) -> None:
    header = make_header(parameters=Params().model_dump())
    EvidenceWriter.create(folder, header).close()
    EvidenceWriter.resume(folder, header).close()
    changed = make_header(parameters=Params().with_settings([("tau", 20)]).model_dump())
    with pytest.raises(EvidenceError, match=r"gate\.tau: 15\.0 against 20\.0"):
        EvidenceWriter.resume(folder, changed)


def test_create_refuses_a_run_and_a_second_writer(folder: Path, header: RunHeader) -> None:
    write_complete_run(folder, header, [make_frame(0)])
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(EvidenceError, match="already holds a run"):
        EvidenceWriter.create(folder, header)
    writer = EvidenceWriter.create(folder, header, overwrite=True)
    assert writer.last_frame is None
    for attempt in (EvidenceWriter.resume, EvidenceWriter.create):
        with pytest.raises(EvidenceError, match=r"Another process|already holds"):
            attempt(folder, header)
    with EvidenceReader(folder) as run:
        assert run.state == "running"
        writer.close()
        assert run.state == "complete"
    assert (folder / "notes.txt").read_text() == "mine"


def test_ordinals_must_be_consecutive(folder: Path, header: RunHeader) -> None:
    with EvidenceWriter.create(folder, header) as writer:
        writer.append(make_frame(3))
        for wrong in (3, 5, 2):
            with pytest.raises(ValueError, match=f"expects frame 4 next. Got {wrong}"):
                writer.append(make_frame(wrong))


def test_without_pixels(folder: Path) -> None:
    write_complete_run(folder, make_header(keep_pixels=False), [make_frame(0)])
    with EvidenceReader(folder) as run:
        assert not run.header.keep_pixels
        assert next(run.frames()).regions == ()
