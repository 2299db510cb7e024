"""``tsr check`` on a reviewed toy drive: the ground truth, regressions, the report and its bundles."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.check.regressions import find_regressions
from app.check.reviewed import ReviewedDrive, reviewed_drive
from app.cli.main import run
from app.exchange.run_sources import run_source
from tests.app.exchange.exchange_client import ExchangeClient
from tsr_engine.bundle import open_bundle
from tsr_engine.evaluation.tracking import evaluate_video
from tsr_engine.track_table import TrackTable


def reviewed(api: ExchangeClient) -> ReviewedDrive | None:
    with api.server.context.database.read() as session:
        return reviewed_drive(run_source(session, api.server.settings, api.run_id))


def review_tracks(api: ExchangeClient) -> None:
    """Accept one track, reject another, leave the third open."""
    api.edit({"name": "set_review", "key": "m1", "frame": 1, "review": "accepted"}, {"m1": 0})
    api.edit({"name": "set_review", "key": "m2", "frame": 1, "review": "rejected"}, {"m2": 0})


def test_verdicts_of_people_are_the_ground_truth(api: ExchangeClient) -> None:
    assert reviewed(api) is None
    review_tracks(api)
    found = reviewed(api)
    assert found is not None
    tracks = api.tracks()
    assert found.decided == 2
    ignored = {int(t) for t in found.truth.track[found.truth.ignore]}
    counted = {int(t) for t in found.truth.track[~found.truth.ignore]}
    assert (len(counted), len(ignored)) == (1, len(tracks) - 2)
    mine = found.truth.boxes[~found.truth.ignore]
    assert np.allclose(mine, tracks["m1"].boxes)
    report = evaluate_video("toy", found.truth, found.results, 75)
    assert len(report.signs) == 1
    assert report.signs[0].covered == report.signs[0].frames
    assert len(report.false_tracks) == 1, "the run itself has the track that a person has rejected"


def test_regressions_are_listed(api: ExchangeClient) -> None:
    review_tracks(api)
    drive = reviewed(api)
    assert drive is not None
    rows = drive.results
    sign = int(
        rows.track[
            np.flatnonzero(np.isclose(rows.boxes[:, 0], drive.truth.boxes[~drive.truth.ignore][0, 0], atol=0.01))[0]
        ]
    )
    lost = rows.rows(rows.track != sign)
    misread = replace(rows, class_id=np.where(rows.track == sign, 40, rows.class_id))
    moved = replace(
        rows, boxes=np.where((rows.track == sign)[:, None], rows.boxes + np.array([400, 0, 400, 0]), rows.boxes)
    )
    before = evaluate_video("toy", drive.truth, rows, 75)

    def kinds(results: TrackTable) -> list[str]:
        after = evaluate_video("toy", drive.truth, results, 75)
        return [place.kind for place in find_regressions([drive], [before], [after], [results])]

    assert kinds(rows) == []
    assert kinds(lost) == ["lost"]
    assert kinds(misread) == ["misread"]
    assert kinds(moved) == ["lost", "false"]


def test_an_imported_run_without_scores_is_measured(api: ExchangeClient) -> None:
    rows = [b"frame,uid,x1,y1,x2,y2,label,state", *(b"%d,m1,10,10,40,40,stop,accepted" % k for k in range(9)), b""]
    imported = api.import_file(b"\n".join(rows), "run", name="theirs.csv")["id"]
    with api.server.context.database.read() as session:
        drive = reviewed_drive(run_source(session, api.server.settings, imported))
    assert drive is not None
    assert np.isnan(drive.results.score).all()
    report = evaluate_video("toy", drive.truth, drive.results, 75)
    assert (report.signs[0].covered, len(report.false_tracks)) == (9, 0)


def test_the_command_reports_regressions_and_makes_bundles(
    api: ExchangeClient, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    out, home = tmp_path / "out", str(api.home)
    command = ["check", "--home", home, "--out", str(out), "--set", "keep_score=50"]
    assert run(command) == 3
    assert "no track has been accepted, drawn or rejected" in capfd.readouterr().err
    review_tracks(api)
    assert run([*command, "--json", "--bundles", "1", "--budget", "found=-50", "--budget", "false=5"]) == 22
    captured = capfd.readouterr()
    found = json.loads(captured.out)
    assert found["figures"]["found"] == {"before": 100.0, "after": 0.0, "difference": -100.0, "interval": None}
    assert found["figures"]["false"]["after"] == 0, "no detection is kept"
    assert [place["kind"] for place in found["places"]] == ["lost"]
    assert "over budget: found went from 100 to 0, by -100; its budget is -50." in captured.err
    page = (out / "check.html").read_text()
    assert found["places"][0]["text"] in page
    assert (out / "crops" / "000.jpg").stat().st_size > 500
    (bundle,) = (out / "bundles").glob("*.zip")
    with open_bundle(bundle) as opened:
        assert opened.manifest.note == found["places"][0]["text"]
    assert run([*command, "drive.mp4", "--bundles", "0"]) == 0, "without a budget nothing is too much"
    assert "1 reviewed drive with 1 sign." in capfd.readouterr().out


def test_two_runs_of_one_video_are_refused(api: ExchangeClient, capfd: pytest.CaptureFixture[str]) -> None:
    review_tracks(api)
    rows = [b"frame,uid,x1,y1,x2,y2,label,state", *(b"%d,m1,10,10,40,40,stop,accepted" % k for k in range(9)), b""]
    imported = api.import_file(b"\n".join(rows), "run", name="theirs.csv")["id"]
    assert run(["check", api.run_id, imported, "--home", str(api.home), "--out", str(api.home / "check")]) == 2
    assert "Two of the runs belong to" in capfd.readouterr().err


def test_a_reviewed_run_of_the_engine_comes_before_a_later_imported_one(
    api: ExchangeClient, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    review_tracks(api)
    rows = [b"frame,uid,x1,y1,x2,y2,label,state", *(b"%d,m1,10,10,40,40,stop,accepted" % k for k in range(9)), b""]
    api.import_file(b"\n".join(rows), "run", name="theirs.csv")
    command = ["check", "--home", str(api.home), "--set", "keep_score=50", "--bundles", "0", "--json"]
    for out, names in (("all", []), ("named", ["drive.mp4"])):
        assert run([*command, *names, "--out", str(tmp_path / out)]) == 0
        assert [drive["run"] for drive in json.loads(capfd.readouterr().out)["drives"]] == [api.run_id]
