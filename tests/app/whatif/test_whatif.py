"""What-ifs: accepted requests, results, and the complete workflow on a bundled drive."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import select

from app.errors import Conflict, Invalid, NotFound
from app.events import EventBus
from app.job_kinds import KINDS
from app.jobs.context import Stopped, TaskContext
from app.jobs.queue import JobQueue
from app.runs.service import RunService
from app.runs.view import started_run
from app.storage.models import Event, Job, Run
from app.whatif.difference import difference
from app.whatif.service import WhatIfService
from app.whatif.task import replay_into, run_whatif
from tests import toy_pipeline
from tests.app import toy_home
from tsr_engine.evidence import EvidenceReader, differences
from tsr_engine.labels.classes import classes_of_keys
from tsr_engine.labels.files import shipped_set
from tsr_engine.params.replayable import is_replayable
from tsr_engine.runs.replay import ReplayReport


def service(home: Any) -> WhatIfService:
    return WhatIfService(home.database, home.events, home.jobs)


def replay_with(home: Any, folder: Path, *settings: tuple[str, object]) -> ReplayReport:
    params, report = toy_pipeline.PARAMS.with_settings(settings), ReplayReport()
    with home.reader() as reader:
        steps = list(replay_into(folder, reader, params, toy_pipeline.components(params), report))
    assert steps == list(range(1, 76))
    return report


def test_replayed_evidence_has_no_pixels(home: Any, tmp_path: Path) -> None:
    report = replay_with(home, tmp_path / "again", ("tau", 3.0))
    assert report.identical == 75
    with EvidenceReader(tmp_path / "again") as new, home.reader() as old:
        assert new.state == "complete"
        assert not new.header.keep_pixels
        assert list(new.frame_table()) == list(old.frame_table())
        for a, b in zip(new.frames(), old.frames(pixels=False), strict=True):
            assert list(differences(a, b, ignore=frozenset({"timings", "regions"}))) == []
        assert list(new.tracks()) == list(old.tracks())


def test_a_repeated_what_if_replaces_itself(home: Any, tmp_path: Path) -> None:
    for tau in (3.5, 4.0):
        replay_with(home, tmp_path / "twice", ("tau", tau))
    with EvidenceReader(tmp_path / "twice") as reader:
        assert reader.header.parameters["gate"]["tau"] == 4.0
        assert len(reader) == 75


def test_lost_tracks_are_listed_with_a_frame(home: Any, tmp_path: Path) -> None:
    report = replay_with(home, tmp_path / "lost", ("birth_score", 50.0))
    found = difference(report, classes_of_keys(None, shipped_set("gtsrb-43")))
    assert found["counts"] == {"gained": 0, "lost": 2, "switched": 0, "relabelled": 0}
    with home.reader() as reader:
        tracks = {track.track_id: track for track in reader.tracks() if track.confirmed}
    assert [entry["track"] for entry in found["lost"]] == sorted(tracks)
    for entry in found["lost"]:
        track = tracks[entry["track"]]
        assert (entry["frame"], entry["class_id"]) == (track.first_frame, track.class_id)
    json.dumps(found, allow_nan=False)


@pytest.mark.parametrize(
    ("asked", "field", "words"),
    [
        ({"min_width": 20.0}, "parameters.min_width", "cannot change min_width"),
        ({"detector.min_width": 20.0}, "parameters.detector.min_width", "new run"),
        ({"use_camera_shift": False}, "parameters.use_camera_shift", "cannot change"),
        ({"tau": -1}, "parameters.tau", "greater than 0"),
        ({"nope": 1}, "parameters.nope", "no parameter"),
        ({"tau": 3.0}, "parameters", "nothing would change"),
    ],
)
def test_invalid_requests_are_refused(home: Any, asked: dict[str, Any], field: str, words: str) -> None:
    with pytest.raises(Invalid, match=words) as caught:
        service(home).start(home.run_id, asked)
    assert caught.value.field == field
    with home.database.read() as session:
        assert session.query(Job).count() == 0
        assert session.query(Run).filter(Run.kind == "whatif").count() == 0


def test_a_focus_that_a_run_has_not_estimated_must_be_named(home: Any) -> None:
    paper = home.add_run(preset="paper")
    with pytest.raises(Invalid, match="which the run has not estimated") as caught:
        service(home).start(paper, {"motion": "looming"})
    assert caught.value.field == "parameters.coast_foe_y"
    assert service(home).start(paper, {"motion": "looming", "coast_foe_y": 0.4}).state == "queued"


def test_an_old_parameter_name_is_accepted_with_a_warning(home: Any) -> None:
    settings = {"pipeline.sought_noise": 5.0}  # former name
    run = service(home).start(home.run_id, settings)
    assert run.parameters == {"tau": 3.0, "pipeline.search_noise": 5.0}
    started = started_run(run, settings)
    assert started.parameters == run.parameters
    assert [warning.split(". ")[0] for warning in started.warnings] == [
        "Parameter 'pipeline.sought_noise' is now called 'pipeline.search_noise'"  # former name
    ]
    with pytest.raises(Invalid, match="Set one of them, not both"):
        service(home).start(home.run_id, {"sought_noise": 5.0, "search_noise": 6.0})  # former name


def test_unknown_and_unfinished_runs_are_refused(home: Any) -> None:
    with pytest.raises(NotFound):
        service(home).start("0" * 32, {"tau": 4})
    running = home.add_run(state="running")
    with pytest.raises(Conflict, match="still running"):
        service(home).start(running, {"tau": 4})
    imported = home.add_run(kind="imported")
    with pytest.raises(Conflict, match="imported"):
        service(home).start(imported, {"tau": 4})


def test_a_what_if_of_a_what_if_replays_the_run_with_both_changes(tmp_path: Path) -> None:
    home = toy_home.make_home(tmp_path, 20)
    first = service(home).start(home.run_id, {"tau": 4.0})
    assert (first.name, first.parent_id, first.kind, first.state) == ("tau = 4", home.run_id, "whatif", "queued")
    second = service(home).start(first.id, {"search_radius": 30}, "wider")
    assert second.parent_id == home.run_id
    assert second.parameters == {"tau": 4.0, "search_radius": 30}
    assert second.name == "wider"
    with home.database.read() as session:
        assert [(job.kind, job.subject) for job in session.query(Job).order_by(Job.order)] == [
            ("whatif", first.id),
            ("whatif", second.id),
        ]
        assert session.query(Event).filter(Event.kind == "run").count() == 2
    home.evidence.close()
    home.database.close()


def test_only_parameters_before_tracking_are_fixed() -> None:
    assert not is_replayable("detector.min_width")
    assert not is_replayable("tracking.shift_scale")
    assert not is_replayable("tracking.foe_y")  # shifts were measured relative to it
    assert is_replayable("tracking.coast_foe_y")
    assert is_replayable("tracking.motion")
    assert is_replayable("gate.tau")


@pytest.mark.slow
def test_the_complete_workflow_on_a_bundled_drive(tmp_path: Path) -> None:
    from app.evidence.pixels import RunPixels
    from app.evidence.service import EvidenceService
    from app.runs.task import track
    from app.settings import Settings
    from app.storage.database import Database
    from app.storage.models import Video
    from sample_videos import SHIPPED
    from tsr_engine.io.video_probe import video_sha256

    settings = Settings(home=tmp_path, sample=False)
    database, events = Database(settings.database), EventBus()
    database.migrate()
    jobs = JobQueue(events, KINDS)
    path = SHIPPED[0].video
    digest = video_sha256(path)
    with database.write() as session:
        session.add(
            Video(id=digest, name=path.name, path=str(path), size=path.stat().st_size, state="ready", frames=300)
        )
        session.flush()
        session.add(Run(id="a" * 32, video_id=digest, folder="runs/a", name="Run 1", first=20, stop=70))
        session.flush()
        jobs.submit(session, "track", "a" * 32)
    leaving = {"now": False}

    def work(task: Any) -> None:
        with database.write() as session:
            job = jobs.claim(session, jobs.waiting_ids(session)[0])
        assert job is not None
        given = TaskContext(settings, database, events, jobs, job, lambda: leaving["now"])
        try:
            task(given)
        except Stopped:
            with database.write() as session:
                jobs.release(session, job.id, job.token)
            raise
        assert given.completed

    work(track)
    requested = WhatIfService(database, events, jobs).start("a" * 32, {"confirm_hits": 5, "coast_foe_y": 0.4})
    work(run_whatif)
    with database.read() as session:
        run = session.get_one(Run, requested.id)
        reported = session.get_one(Run, "a" * 32).summary["focus"]
        assert reported == {"x": 0.5, "y": pytest.approx(0.44, abs=0.01), "named": False}
    assert run.summary["focus"] == {"x": 0.5, "y": 0.4, "named": True}
    assert (run.state, run.frames_done, run.frames_total) == ("complete", 50, 50)
    assert set(run.summary["difference"]["counts"]) == {"gained", "lost", "switched", "relabelled"}
    assert run.summary["identical_frames"] < 50
    evidence = EvidenceService(settings, database)
    columns = json.loads(evidence.tracks(requested.id))
    assert len(columns["id"]) == run.tracks
    # Crops of a what-if come from the run that it replays.
    lane = evidence.track(requested.id, columns["id"][0])

    def no_picture(video: str, frame: int) -> Any:
        raise AssertionError("the run that it replays has the pixels")

    pixels = RunPixels(settings, database, evidence)
    assert pixels.crop(requested.id, lane.id, lane.frame[0], 64, "result", no_picture)[:4] == b"\x89PNG"
    evidence.close()
    leaving["now"] = True
    WhatIfService(database, events, jobs).start("a" * 32, {"tau": 30.0})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("app.whatif.task.PROGRESS_INTERVAL_S", 0.0)
        with pytest.raises(Stopped):
            work(run_whatif)
    leaving["now"] = False
    work(run_whatif)
    database.close()


def runs(home: Any) -> RunService:
    return RunService(home.settings, home.database, home.events, home.jobs)


def test_a_run_can_be_renamed_and_pages_are_notified(home: Any) -> None:
    made = home.add_run(name="tau = 20", kind="whatif", parent_id=home.run_id)
    assert runs(home).rename(made, "  Stricter gate ").name == "Stricter gate"
    with home.database.read() as session:
        reported = session.scalars(select(Event).where(Event.subject == made).order_by(Event.seq.desc())).first()
        assert reported is not None
        assert (reported.kind, reported.data["name"]) == ("run", "Stricter gate")
    with pytest.raises(Invalid, match="needs a name"):
        runs(home).rename(made, "   ")
    with pytest.raises(NotFound):
        runs(home).rename("0" * 32, "x")


def test_all_what_ifs_of_a_run_are_removed_at_once(home: Any) -> None:
    origin = home.add_run(name="Origin")
    other = home.add_run(name="Other")
    whatifs = [home.add_run(kind="whatif", parent_id=origin) for _ in range(2)]
    going = home.add_run(kind="whatif", parent_id=origin, state="running")
    other_whatif = home.add_run(kind="whatif", parent_id=other)
    for name in (*whatifs, other_whatif):
        (home.settings.home / "runs" / name).mkdir(parents=True)
    assert sorted(runs(home).remove_whatifs(origin)) == sorted(whatifs)
    with home.database.read() as session:
        left = set(session.scalars(select(Run.id)))
    assert {origin, other, going, other_whatif} <= left
    assert not left & set(whatifs)
    assert [(home.settings.home / "runs" / name).exists() for name in (*whatifs, other_whatif)] == [False, False, True]
    assert runs(home).remove_whatifs(origin) == []
    with pytest.raises(NotFound):
        runs(home).remove_whatifs("0" * 32)
