"""Bundles are made and replayed: the run repeats bit by bit, and the verdict follows the expectation."""

from __future__ import annotations

import json
import os
import zipfile
from pathlib import Path
from typing import Any

import pytest

from tests import toy_pipeline
from tests.bundle.tracked_drive import TrackedDrive, make_expectation
from tsr_engine.bundle import BundleReplay, bundle_params, make_bundle, open_bundle, replay_bundle
from tsr_engine.bundle.lead_in import find_lead_in
from tsr_engine.bundle.request import BundleRequest
from tsr_engine.errors import EvidenceError, InputError, StorageError, UsageError
from tsr_engine.evidence import EvidenceReader, differences
from tsr_engine.io.unfinished import create_locked_folder


def replay(drive: TrackedDrive, path: Path, *settings: tuple[str, object]) -> BundleReplay:
    with open_bundle(path) as bundle:
        params, strange = bundle_params(bundle)
        assert strange == []
        params = params.with_settings(settings)
        return replay_bundle(bundle, params, toy_pipeline.components(params))


def second_sign(drive: TrackedDrive, first: int = 48, stop: int = 66) -> dict[str, Any]:
    """The sign that is in view from frame 44 on, as drawn."""
    frames = list(range(first, stop))
    return {"frames": frames, "boxes": [toy_pipeline.sign_box(k % 40).tolist() for k in frames]}


def expectation_unmet(drive: TrackedDrive, *kinds: str, **more: Any) -> Any:
    expected = [{"id": kind, "kind": kind, "sign": "s", **more} for kind in kinds]
    return make_expectation(signs={"s": second_sign(drive)}, expected=expected)


def test_a_replay_repeats_the_run_bit_by_bit_in_the_middle_of_a_track(drive: TrackedDrive, plain: Path) -> None:
    report = replay(drive, plain)
    assert (report.frames, report.judged, report.identical) == (67, 24, 24), report.first_difference
    assert (report.same, report.other_pictures, report.changed) == (True, 0, [])
    assert (report.tracks, report.tracks_before) == (2, 2)
    assert report.verdict == "unchanged"


def test_the_state_is_rebuilt_from_a_frame_without_tracks(drive: TrackedDrive) -> None:
    with EvidenceReader(drive.run) as reader:
        assert [find_lead_in(reader, first).start for first in (0, 3, 4, 60)] == [0, 2, 3, 3]
        assert find_lead_in(reader, 60).first_id == 1
        cut = find_lead_in(reader, 60, max_frames=10)
        assert (cut.start, cut.is_exact, cut.first_id) == (50, False, 3)


def test_a_long_lead_in_is_cut_and_reported(drive: TrackedDrive, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setattr(
        "tsr_engine.bundle.make.find_lead_in", lambda reader, first: find_lead_in(reader, first, max_frames=5)
    )
    made = drive.bundle(tmp_path / "cut.zip", 60, 70)
    assert not made.manifest.frames.whole_lead_in
    assert any("starts at frame 55" in warning for warning in made.warnings)
    with zipfile.ZipFile(made.path) as archive:
        assert "That is not quite so here" in archive.read("README.txt").decode().replace("\n  ", " ")
    report = replay(drive, made.path)
    assert report.identical is not None
    assert report.identical < 10


def test_the_same_request_gives_the_same_bytes(drive: TrackedDrive, plain: Path, tmp_path: Path) -> None:
    assert drive.bundle(tmp_path / "again.zip").path.read_bytes() == plain.read_bytes()


def test_still_broken_then_fixed_then_different(drive: TrackedDrive, tmp_path: Path) -> None:
    wrong = drive.bundle(tmp_path / "a.zip", expectation=expectation_unmet(drive, "absent"))
    assert [finding.met for finding in wrong.findings] == [False]
    report = replay(drive, wrong.path)
    assert report.verdict == "still broken"
    assert report.outcomes[0].verdict == "still broken"
    assert "Track 2 lies there in 18 of 18 frames" in report.outcomes[0].got
    fixed = replay(drive, wrong.path, ("birth_score", 50.0))
    assert (fixed.verdict, fixed.outcomes[0].verdict, fixed.same, fixed.tracks) == ("fixed", "fixed", False, 0)
    both = drive.bundle(tmp_path / "b.zip", expectation=expectation_unmet(drive, "absent", "found"))
    other = replay(drive, both.path, ("birth_score", 50.0))
    assert other.verdict == "different"
    assert [one.verdict for one in other.outcomes] == ["fixed", "newly broken"]


def test_without_expectation_another_output_is_different(drive: TrackedDrive, plain: Path) -> None:
    assert replay(drive, plain, ("birth_score", 50.0)).verdict == "different"


def test_a_bundle_of_a_correct_run_warns(drive: TrackedDrive, tmp_path: Path) -> None:
    made = drive.bundle(tmp_path / "right.zip", expectation=expectation_unmet(drive, "found"))
    assert "meets every expectation" in made.warnings[0]
    assert replay(drive, made.path).verdict == "fixed"


def test_files_of_a_bundle(drive: TrackedDrive, plain: Path) -> None:
    with zipfile.ZipFile(plain) as archive:
        names = set(archive.namelist())
        readme = archive.read("README.txt").decode()
        manifest = json.loads(archive.read("manifest.json"))
        rows = archive.read("output.csv").decode().splitlines()
    expected = {"README.txt", "manifest.json", "clip.mp4", "frames.csv", "output.csv", "expectation.json"}
    assert names == expected | {"corrections.json", "evidence/run.json", "evidence/evidence.sqlite"}
    assert {entry["name"] for entry in manifest["files"]} == names - {"manifest.json"}
    for word in ("tsr replay", "exit code 20", "wrong", "drive.mp4", "frames 46 to 69", "still broken", "unchanged"):
        assert word in readme
    assert max(map(len, readme.splitlines())) <= 100
    assert rows[0] == "frame,track_id,x1,y1,x2,y2,class_id,score,source"
    assert {int(row.split(",")[0]) for row in rows[1:]} == set(range(46, 70))


def test_the_bundled_evidence_equals_the_runs(drive: TrackedDrive, plain: Path) -> None:
    with open_bundle(plain) as bundle, EvidenceReader(bundle.folder / "evidence") as stored:
        assert stored.state == "complete"
        with EvidenceReader(drive.run) as run:
            for a, b in zip(stored.frames(), run.frames(3, 70), strict=True):
                assert list(differences(a, b)) == []


def test_a_recording_is_bundled_or_the_readme_says_why_not(
    drive: TrackedDrive, tmp_path: Path, monkeypatch: Any
) -> None:
    made = drive.bundle(tmp_path / "with.zip", recording=True)
    with zipfile.ZipFile(made.path) as archive:
        assert archive.read("recording.rrd")[:4] == b"RRF2"
    assert replay(drive, made.path).verdict == "unchanged"

    def broken(*_: Any) -> None:
        raise UsageError("A viewer cannot hold that.")

    monkeypatch.setattr("tsr_engine.bundle.make.write_recording", broken)
    without = drive.bundle(tmp_path / "without.zip", recording=True)
    assert without.manifest.recording == "could not be made (A viewer cannot hold that)."


def test_runs_that_cannot_be_bundled(drive: TrackedDrive, tmp_path: Path) -> None:
    out = tmp_path / "no.zip"
    for first, stop, words in ((5, 5, "are none"), (0, 99, "ends with frame 74"), (80, 90, "ends with frame 74")):
        with pytest.raises(UsageError, match=words):
            drive.bundle(out, first, stop)
    with pytest.raises(UsageError, match="about the frames 48 to 65"):
        drive.bundle(out, 60, 70, expectation=expectation_unmet(drive, "found"))
    with pytest.raises(StorageError, match="is a folder"):
        drive.bundle(tmp_path)
    with pytest.raises(UsageError, match="is the input itself"):
        make_bundle(BundleRequest(drive.run, drive.video, drive.video, 0, 5))
    with pytest.raises(InputError, match="no video at"):
        make_bundle(BundleRequest(drive.run, tmp_path / "gone.mp4", out, 0, 5))
    other = toy_pipeline.write_drive(tmp_path / "other.mp4", 6)
    with pytest.raises(EvidenceError, match="is not the video of the run"):
        make_bundle(BundleRequest(drive.run, other, out, 0, 5))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["other.mp4"]


def test_leftovers_of_a_killed_process_are_removed(drive: TrackedDrive, tmp_path: Path) -> None:
    out = tmp_path / "bug.zip"
    (tmp_path / ".bug.zip.abc.part").mkdir()
    (tmp_path / ".bug.zip.abc.part" / "clip.mp4").write_bytes(b"half")
    living, lock = create_locked_folder(out)
    out.write_bytes(b"the old one")

    def stop(done: int, of: int) -> None:
        if done > of // 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_bundle(BundleRequest(drive.run, drive.video, out, 46, 60, recording=False), stop)
    os.close(lock)
    assert out.read_bytes() == b"the old one"
    assert sorted(path.name for path in tmp_path.iterdir()) == [living.name, "bug.zip"]


def test_settings_of_another_version_are_reported_not_refused(drive: TrackedDrive, plain: Path) -> None:
    with open_bundle(plain) as bundle:
        run = bundle.manifest.run
        parameters = {**run.parameters, "gate": {**run.parameters["gate"], "magic": 3, "tau": -1}}
        parameters["pipeline"] = {k: v for k, v in run.parameters["pipeline"].items() if k != "reader"}
        del parameters["fusion"]
        manifest = bundle.manifest.model_copy(
            update={"run": run.model_copy(update={"parameters": parameters, "engine_version": "9.9"})}
        )
        object.__setattr__(bundle, "manifest", manifest)
        params, strange = bundle_params(bundle)
        report = replay_bundle(bundle, params, toy_pipeline.components(params))
    assert any("gate.magic" in text for text in strange)
    assert any("gate.tau" in text and "not allowed" in text for text in strange)
    assert any("has no parameter fusion." in text and "its default is used" in text for text in strange)
    assert "The run has no parameter pipeline.reader: it replays as it was made." in strange
    assert params.pipeline.reader == "classifier", "as all runs did before there was a choice"
    assert any("engine 9.9" in text for text in report.changed)
