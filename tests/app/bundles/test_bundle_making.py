"""A bundle of the tool's run: requested, made, downloaded, replayed; also from the command line."""

from __future__ import annotations

import json
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from app.bundles import request
from app.cli.main import run
from app.edits.documents import KeyFrame, Segment, TrackDoc
from app.errors import Conflict, Invalid, NotFound
from app.exchange.run_sources import run_source
from app.storage.models import Output, Run
from tests import toy_pipeline
from tests.app import toy_home
from tests.app.bundles.toy_bundle import (
    FIRST,
    STOP,
    ToyBundle,
    bundle_service,
    corrections,
    output_service,
    store_documents,
)
from tsr_engine.bundle import bundle_params, open_bundle, replay_bundle
from tsr_engine.bundle.lead_in import LeadIn


def test_content_of_a_bundle(bundled: ToyBundle) -> None:
    summary = bundled.summary
    assert (summary["first"], summary["stop"], summary["lead_in"]) == (FIRST, STOP, FIRST - 3)
    assert [(one["id"], one["met"]) for one in summary["expected"]] == [
        ("habcdef.found", False),
        ("habcdef.label", False),
        ("m2.label", False),
        ("m2.boxes", True),
    ]
    with zipfile.ZipFile(bundled.path) as archive:
        documents = json.loads(archive.read("corrections.json"))["documents"]
        readme = " ".join(archive.read("README.txt").decode().split())
        assert archive.read("recording.rrd")[:4] == b"RRF2"
    assert [document["key"] for document in documents] == ["habcdef", "m2"]
    assert "reads as a stop sign" in readme
    assert "did not come true" in readme


@pytest.mark.parametrize(("start", "label"), [(51, None), (52, 14)])
def test_a_track_without_evidence_keeps_its_label(
    home: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, start: int, label: int | None
) -> None:
    monkeypatch.setattr(request, "find_lead_in", lambda *_: LeadIn(start, 2, False))
    drawn = TrackDoc(key="m1", segments=(Segment(track=1, first=4, last=51),), keys={"60": KeyFrame(box=(0, 0, 9, 9))})
    with home.database.read() as session:
        source = replace(run_source(session, home.settings, home.run_id), documents={"m1": drawn})
    corrections = request.bundle_request(source, tmp_path / "bug.zip", 55, 70).corrections
    assert [each["class_id"] for each in corrections["documents"]] == [label]
    assert set(corrections["labels"]) == ({"14"} if label else set())


def test_it_replays_on_another_machine(bundled: ToyBundle) -> None:
    with open_bundle(bundled.path) as bundle:
        params, strange = bundle_params(bundle)
        report = replay_bundle(bundle, params, toy_pipeline.components(params))
    assert (strange, report.changed) == ([], [])
    assert (report.verdict, report.identical, report.judged) == ("still broken", 24, 24)
    assert [one.verdict for one in report.outcomes] == ["still broken", "still broken", "still broken", "right"]


@pytest.mark.parametrize(
    ("first", "stop", "tracks", "field"),
    [
        (5, 5, [], "stop"),
        (0, 3001, [], "stop"),
        (0, 76, [], "stop"),
        (0, 9, ["m99"], "tracks"),
        (0, 9, ["h123456"], "tracks"),
    ],
)
def test_invalid_requests_are_refused(home: Any, first: int, stop: int, tracks: list[str], field: str) -> None:
    with pytest.raises(Invalid) as caught:
        bundle_service(home).start(home.run_id, first, stop, tracks=tracks)
    assert caught.value.field == field


def test_runs_that_cannot_be_packed(home: Any) -> None:
    with pytest.raises(NotFound):
        bundle_service(home).start("0" * 32, 0, 5)
    imported = home.add_run(kind="imported", folder=f"runs/{home.run_id}")
    with pytest.raises(Conflict, match="another program"):
        bundle_service(home).start(imported, 0, 5)
    running = home.add_run(state="running", folder=f"runs/{home.run_id}")
    with pytest.raises(Conflict, match="still running"):
        bundle_service(home).start(running, 0, 5)
    with home.database.write() as session:
        for run_id in (imported, running):
            session.delete(session.get_one(Run, run_id))


def test_the_command_line_makes_the_same(bundled: ToyBundle, tmp_path: Path, capfd: Any) -> None:
    home, out = bundled.home, tmp_path / "bug.zip"
    arguments = [
        "bundle",
        home.run_id,
        "--home",
        str(home.settings.home),
        "--frames",
        f"{FIRST}:{STOP}",
        "--out",
        str(out),
    ]
    assert run([*arguments, "--note", "reads as a stop sign", "--json", "--no-recording"]) == 0
    reported = json.loads(capfd.readouterr().out)
    assert [one["met"] for one in reported["expected"]] == [False, False, False, True]
    with zipfile.ZipFile(out) as from_command, zipfile.ZipFile(bundled.path) as from_server:
        for name in ("clip.mp4", "evidence/evidence.sqlite", "expectation.json", "corrections.json", "output.csv"):
            assert from_command.read(name) == from_server.read(name), name


def test_the_command_line_on_a_bare_folder(home: Any, tmp_path: Path, capfd: Any) -> None:
    import shutil

    bare, out = tmp_path / "run1", tmp_path / "bug.zip"
    shutil.copytree(home.folder, bare)
    expect = tmp_path / "expectation.json"
    signs = {"s": {"frames": [48], "boxes": [[0, 0, 20, 20]]}}
    expect.write_text(json.dumps({"signs": signs, "expected": [{"id": "a", "kind": "found", "sign": "s"}]}))
    arguments = ["bundle", str(bare), "--frames", "46:50", "--out", str(out), "--no-recording"]
    assert run([*arguments, "--expect", str(expect)]) == 3
    assert "--video" in capfd.readouterr().err
    assert run([*arguments, "--video", str(home.video), "--expect", str(expect)]) == 0
    assert "WRONG: The sign s (frame 48) is found" in capfd.readouterr().out
    assert run([*arguments, "--video", str(home.video), "--track", "m77"]) == 2
    assert "no track 'm77'" in capfd.readouterr().err
    assert run([*arguments, "--out", str(tmp_path / "bug.rar")]) == 2
    assert "A bundle is a ZIP file. Name it FILE.zip" in capfd.readouterr().err
    assert run([*arguments, "--models", str(tmp_path)]) == 4
    assert str(tmp_path) in capfd.readouterr().err


def test_a_missing_video_is_reported(tmp_path: Path) -> None:
    home = toy_home.make_home(tmp_path, 20)
    home.video.unlink()
    with pytest.raises(Conflict, match="is missing"):
        bundle_service(home).start(home.run_id, 0, 9)
    home.evidence.close()
    home.database.close()


def test_a_removed_bundle_loses_its_file(bundled: ToyBundle) -> None:
    home = bundled.home
    store_documents(home, *corrections())
    requested = bundle_service(home).start(home.run_id, 60, 64, tracks=["m2"])
    assert (requested.kind, requested.state, requested.name) == ("bundle", "queued", "drive_60-63_bug.zip")
    output_service(home).cancel(requested.id)
    with home.database.read() as session:
        assert session.get_one(Output, requested.id).state == "cancelled"
