"""The content of a recording, box by box against the evidence."""

from __future__ import annotations

import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.recording import synthetic_run
from tests.recording.read_back import ReadBack
from tsr_engine.errors import EvidenceError, StorageError, UsageError
from tsr_engine.evidence import EvidenceReader
from tsr_engine.recording import LAYERS, BoxRows, RecordingReport, RecordingRequest, write_recording
from tsr_engine.recording.layers import TAU_COLOUR, TRACK_COLOURS
from tsr_engine.records import FrameEvidence
from tsr_engine.track_table import TrackTable

FIRST, STOP = 1, 26


def rows(frames: list[int], label: str) -> BoxRows:
    n = len(frames)
    boxes = np.arange(n * 4, dtype=float).reshape(n, 4) + np.array([0, 0, 9, 9])
    return BoxRows(
        TrackTable(np.array(frames), np.zeros(n, int), boxes, np.array([14] * n)), tuple(f"{label}{k}" for k in frames)
    )


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = synthetic_run.write_run(tmp_path_factory.mktemp("runs") / "run")
    return folder


@pytest.fixture(scope="module")
def report(run: Path, tmp_path_factory: pytest.TempPathFactory) -> RecordingReport:
    request = RecordingRequest(
        run,
        tmp_path_factory.mktemp("out") / "a.rrd",
        FIRST,
        STOP,
        corrected=rows([24, 0, 6, 6, 29], "h"),
        truth=rows([3], "t"),
        focus_frame=8,
        focus_track=9,
    )
    return write_recording(request)


@pytest.fixture(scope="module")
def read_back(report: RecordingReport) -> Any:
    return ReadBack(report.path)


@pytest.fixture(scope="module")
def stored(run: Path) -> list[FrameEvidence]:
    with EvidenceReader(run) as reader:
        return list(reader.frames(FIRST, STOP))


def expected(layer: str, frame: FrameEvidence) -> list[np.ndarray]:
    """The boxes of a layer in a frame, from the records."""
    alive = [t for t in frame.tracks if t.state != "dead"]
    by_number = sorted(alive, key=lambda t: t.track_id)
    found = [t.relocalisation for t in by_number if t.relocalisation is not None]
    foreseen = [t.prediction for t in by_number if t.prediction is not None]
    if layer in ("detections", "detections_raw"):
        return list(frame.detections.boxes)
    if layer == "results":
        return [t.box for t in alive]
    if layer == "predictions":
        return [p.box for p in foreseen]
    if layer == "innovation":
        middle = [(p.box[:2] + p.box[2:]) / 2 for p in foreseen]
        spread = [np.sqrt(np.diag(p.covariance)[:2]) for p in foreseen]
        return [np.concatenate([m - s, m + s]) for m, s in zip(middle, spread, strict=True)]
    if layer == "search":
        return [r.search_box for r in found]
    if layer == "relocalisations":
        return [r.box for r in found]
    return [r.runner_up_box for r in found]


@pytest.mark.parametrize("layer", [name for name in LAYERS if name not in ("corrected", "truth")])
def test_boxes_equal_the_evidence(
    layer: str, read_back: Any, stored: list[FrameEvidence], report: RecordingReport
) -> None:
    boxes = read_back.boxes(LAYERS[layer].entity)
    assert sorted(boxes) == list(range(FIRST, STOP)), "a frame without boxes must be said to be empty"
    for frame in stored:
        want = np.array(expected(layer, frame)).reshape(-1, 4)
        assert boxes[frame.ordinal].shape == want.shape
        np.testing.assert_allclose(boxes[frame.ordinal], want, atol=1e-4)
    assert report.boxes[layer] == sum(len(b) for b in boxes.values()) > 0
    assert any(len(b) == 0 for b in boxes.values())


def test_corrections_and_truth_come_from_the_caller(read_back: Any, report: RecordingReport) -> None:
    given = rows([24, 0, 6, 6, 29], "h")
    boxes = read_back.boxes("video/corrected")
    assert {k: len(b) for k, b in boxes.items() if len(b)} == {6: 2, 24: 1}, "those outside the range are left out"
    np.testing.assert_allclose(boxes[24], given.table.boxes[:1])
    np.testing.assert_allclose(boxes[6], given.table.boxes[2:4])
    assert read_back.column("video/corrected", "Boxes2D:labels")[6] == ["h6", "h6"]
    assert read_back.column("video/corrected", "Boxes2D:class_ids")[24] == [14]
    assert report.boxes["truth"] == 1


def test_a_result_keeps_the_label_of_its_corrected_box(read_back: Any, run: Path, tmp_path: Path) -> None:
    def labelled(recording: Any, layer: str) -> bool:
        return bool(recording.static(LAYERS[layer].entity, "Boxes2D:show_labels")[0])

    assert (labelled(read_back, "corrected"), labelled(read_back, "results")) == (True, False)
    assert read_back.column("video/results", "Boxes2D:labels")[2], "the pointer still reads them"
    for corrected in (None, rows([29], "h")):  # no corrections, or none in these frames
        out = tmp_path / "plain.rrd"
        write_recording(RecordingRequest(run, out, FIRST, STOP, corrected=corrected))
        assert labelled(ReadBack(out), "results")


def test_lines_of_different_tracks_have_different_colours(read_back: Any, report: RecordingReport) -> None:
    def colours(track: int, value: str) -> list[int]:
        found: list[int] = read_back.static(f"tracks/m{track}/{value}", "SeriesLines:colors")
        return found

    def packed(rgb: tuple[int, int, int]) -> int:
        return rgb[0] << 24 | rgb[1] << 16 | rgb[2] << 8 | 255

    assert len(report.tracks) == 2
    for value, width in (("gate/log10_l_positive", 1), ("score", 3), ("votes", 3)):
        one, two = (colours(track, value) for track in report.tracks)
        assert len(one) == len(two) == width
        assert len({*one, *two}) == 2 * width, value
    assert colours(report.tracks[0], "svm/decision") == [packed(TRACK_COLOURS[0])], "a track keeps its colour"
    assert read_back.static("gate/log10_tau", "SeriesLines:colors") == [packed(TAU_COLOUR)]


def test_colours_of_tracks_can_be_told_from_each_other_and_from_the_threshold() -> None:
    import cv2

    lab = cv2.cvtColor(np.array([[*TRACK_COLOURS, TAU_COLOUR]], np.float32) / 255, cv2.COLOR_RGB2LAB)[0]
    apart = np.linalg.norm(lab[:, None] - lab[None], axis=2) + 1e3 * np.eye(len(lab))
    assert apart.min() > 25, "ten times what one can just tell apart"


def test_classes_have_names_and_colours(read_back: Any, stored: list[FrameEvidence]) -> None:
    context = read_back.static("video", "AnnotationContext:context")
    names = {row["class_id"]: row["class_description"]["info"] for row in context[0]}
    assert names[14]["label"] == "14 stop"
    assert names[43]["label"] == "unknown"
    assert len({names[c]["color"] for c in range(43)}) > 10
    shown = read_back.column("video/results", "Boxes2D:class_ids")
    for frame in stored:
        want = [t.recognition.class_id for t in frame.tracks if t.state != "dead" and t.recognition is not None]
        assert (shown[frame.ordinal] or []) == want


def test_values_over_time_equal_the_evidence(read_back: Any, stored: list[FrameEvidence]) -> None:
    def values(entity: str) -> dict[int, float]:
        return {k: v[0] for k, v in read_back.column(entity, "Scalars:scalars").items()}

    of_7 = {f.ordinal: t for f in stored for t in f.tracks if t.track_id == 7}
    judged = {k: t.gate for k, t in of_7.items() if t.gate is not None}
    assert values("tracks/m7/gate/l_positive") == pytest.approx({k: g.l_positive for k, g in judged.items()})
    assert values("tracks/m7/gate/hash_distance") == pytest.approx({k: g.hash_distance for k, g in judged.items()})
    logs = {k: np.log10(g.l_positive) for k, g in judged.items()}
    assert values("tracks/m7/gate/log10_l_positive") == pytest.approx(logs)
    found = {k: t.relocalisation.decision for k, t in of_7.items() if t.relocalisation is not None}
    assert values("tracks/m7/svm/decision") == pytest.approx(found)
    scores = read_back.column("tracks/m7/score", "Scalars:scalars")
    assert {k: v[0] for k, v in scores.items()} == pytest.approx({k: t.score for k, t in of_7.items()})
    assert np.isnan(scores[3][1]), "no detection, no raw score"
    prior = next(f for f in stored if f.ordinal == 2).detections.prior[0]
    assert scores[2][2] == pytest.approx(prior)
    leading = [int(name.split()[-2]) for name in read_back.static("tracks/m7/votes", "SeriesLines:names")]
    votes = read_back.column("tracks/m7/votes", "Scalars:scalars")
    for k, t in of_7.items():
        assert t.recognition is not None
        share = t.recognition.votes / t.recognition.votes.sum()
        assert dict(zip(leading, votes[k], strict=True)) == pytest.approx({c: share[c] for c in leading})
    assert sorted(leading) == [0, 1, 2]
    assert set(values("gate/tau").values()) == {15.0}
    assert sorted(values("gate/tau")) == list(range(FIRST, STOP))


def test_states_change_with_the_source(read_back: Any) -> None:
    states = read_back.column("tracks/m7/state", "StateChange:state")
    assert states[2] == ["detected"]
    assert states[3] == ["relocalised"]
    assert states[10] == [""], "a gap is a state"
    assert states[13] == ["detected"]
    assert states[21] == [""], "the track has gone"
    ended = read_back.column("tracks/m9/state", "StateChange:state")
    assert ended[15] == [""], "in the frame in which it dies a track has no result"


def test_events_and_times(read_back: Any) -> None:
    assert read_back.column("events", "TextLog:text") == {8: ["#7: Track 7 was rejected."]}
    batch = read_back.of("video/results")[0]
    assert {"frame", "time"} <= set(batch.schema.names)
    times = batch.column(batch.schema.names.index("time")).cast("int64").to_pylist()
    frames = batch.column(batch.schema.names.index("frame")).to_pylist()
    assert times == pytest.approx([k / 25 * 1e9 for k in frames], abs=1)


def test_properties_name_the_sources(read_back: Any, run: Path) -> None:
    with EvidenceReader(run) as reader:
        header = reader.header
    entity = next(e for e in read_back.entities() if e.endswith("properties/tsr"))
    assert read_back.static(entity, "engine_version") == [header.engine_version]
    assert '"detector": "cdcd' in read_back.static(entity, "models")[0]
    assert '"tau": 15.0' in read_back.static(entity, "configuration")[0]
    assert read_back.static(entity, "sdk_version")[0].startswith("0.41.")
    assert "without the video" in read_back.static(entity, "picture")[0]
    assert "# drive.mp4, frames 1 to 25" in read_back.static("about", "TextDocument:text")[0]


def test_the_sdk_reports_no_error(report: RecordingReport) -> None:
    command = [sys.executable, "-m", "rerun_cli", "rrd", "verify", str(report.path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    assert done.returncode == 0, done.stderr
    assert "1 file verified without error" in done.stdout + done.stderr


def test_a_viewer_opens_the_prepared_views(report: RecordingReport) -> None:
    """A default blueprint arrived too late: the viewer had made a view for each entity."""
    command = [sys.executable, "-m", "rerun_cli", "rrd", "print", str(report.path)]
    output = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300).stdout
    orders = [line for line in output.splitlines() if line.startswith("BlueprintActivationCommand")]
    assert len(orders) == 1
    assert "make_active: true, make_default: true" in orders[0]
    views = output.count("ViewBlueprint:class_identifier")
    assert views >= 4, "picture, events, about, states"
    assert output.rindex("ViewBlueprint:class_identifier") < output.index(orders[0]), "complete before it is shown"


def test_equal_content_has_an_equal_name_and_other_content_another(
    run: Path, report: RecordingReport, tmp_path: Path
) -> None:
    plain = RecordingRequest(run, tmp_path / "b.rrd", FIRST, STOP)
    one, two = write_recording(plain), write_recording(plain)
    assert one.recording_id == two.recording_id != report.recording_id
    assert not list(tmp_path.glob(".*")), "no temporary file stays"


def test_frames_without_a_track_are_recorded(run: Path, tmp_path: Path) -> None:
    report = write_recording(RecordingRequest(run, tmp_path / "x.rrd", 0, 2))
    assert (report.tracks, report.boxes["results"]) == ((), 0)
    assert report.size == (tmp_path / "x.rrd").stat().st_size > 0


def test_a_range_outside_of_the_run_is_refused(run: Path, tmp_path: Path) -> None:
    for first, stop in ((0, 31), (5, 5), (-1, 3)):
        with pytest.raises(UsageError, match=f"^The run in {run} has stored the frames 0 to 29"):
            write_recording(RecordingRequest(run, tmp_path / "x.rrd", first, stop))
    with pytest.raises(UsageError, match=r"^The run 'Run 1' of drive\.mp4 has stored the frames 0 to 29"):
        write_recording(RecordingRequest(run, tmp_path / "x.rrd", 5, 31, called="the run 'Run 1' of drive.mp4"))
    assert not list(tmp_path.iterdir())


def test_another_video_is_refused(run: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.mp4"
    other.write_bytes(b"something else")
    with pytest.raises(EvidenceError, match="is not the video of the run"):
        write_recording(RecordingRequest(run, tmp_path / "x.rrd", video=other))
    assert not (tmp_path / "x.rrd").exists()


def test_an_old_recording_is_kept_when_the_new_one_is_stopped(run: Path, tmp_path: Path) -> None:
    out = tmp_path / "x.rrd"
    out.write_bytes(b"the old one")

    def stop(done: int, _of: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_recording(RecordingRequest(run, out), stop)
    assert out.read_bytes() == b"the old one"
    assert [p.name for p in tmp_path.iterdir()] == ["x.rrd"]


def test_a_folder_in_the_way_is_one_sentence(run: Path, tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="it is a folder"):
        write_recording(RecordingRequest(run, tmp_path))


def test_a_full_disk_leaves_no_file_and_is_reported(run: Path, tmp_path: Path) -> None:
    out = tmp_path / "x.rrd"
    out.write_bytes(b"the old one")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, hard))
    try:
        with pytest.raises(StorageError, match=r"Cannot write .*x\.rrd: the file would be larger"):
            write_recording(RecordingRequest(run, out))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert out.read_bytes() == b"the old one"
    assert [p.name for p in tmp_path.iterdir()] == ["x.rrd"]
