"""A job of any kind that is cancelled just before its last transaction ends cancelled, and its result is not stored."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import pytest
from sqlalchemy import select

from app.follows import service
from app.job_kinds import KINDS
from app.jobs.context import TaskContext
from app.jobs.worker import execute
from app.outputs.folders import output_folder
from app.storage.models import Event, Follow, FollowPiece, Job, ModelVersion, Output, Run, Video
from tests import toy_pipeline
from tests.app.inline_worker import run_jobs
from tests.app.jobs.job_server import KNOWN_FOCUS
from tests.app.toy_home import ToyHome, make_home
from tests.app.toy_server import Server
from tsr_engine.evidence import EvidenceReader

FRAMES = 8


class JobApi:
    """A server on a toy home, with a complete run of the shipped models."""

    def __init__(self, home: ToyHome, server: Server) -> None:
        self.home, self.server, self.context = home, server, server.context
        self.run = self.start_run()
        run_jobs(self.context, "track")

    def post(self, path: str, body: Any = None) -> Any:
        answer = self.server.client.post(f"/api/{path}", json=body)
        assert answer.status_code == 202, answer.text
        return answer.json()

    def rows(self, query: Any) -> Sequence[Any]:
        with self.context.database.read() as session:
            return session.scalars(query).all()

    def row(self, table: type, row_id: str) -> Any:
        with self.context.database.read() as session:
            return session.get(table, row_id)

    def start_run(self) -> str:
        return self.context.runs.start(self.home.video_id, stop=FRAMES, parameters=KNOWN_FOCUS).id

    def claimed(self, subject: str) -> TaskContext:
        """The job of a subject, as a worker holds it."""
        c = self.context
        (job,) = self.rows(select(Job).where(Job.subject == subject))
        with c.database.write() as session:
            held = c.jobs.claim(session, job.id)
        assert held is not None
        return TaskContext(c.settings, c.database, c.events, c.jobs, held, lambda: False)

    def states(self, subject: str) -> list[str]:
        """The states that pages have read in events about a subject."""
        events = self.rows(select(Event).where(Event.subject == subject).order_by(Event.seq))
        return [event.data["state"] for event in events if "state" in event.data]


@pytest.fixture(scope="module")
def api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[JobApi]:
    home = make_home(tmp_path_factory.mktemp("cancelled"), 80)
    server = Server(home.settings.home, roots=(home.video.parent,))
    with server.client, pytest.MonkeyPatch.context() as patch:
        patch.setattr(service, "LEASE_S", 600.0)  # no page reads its follow
        yield JobApi(home, server)
    home.evidence.close()
    home.database.close()


def start_import(api: JobApi) -> str:
    return str(api.context.videos.add_path(str(toy_pipeline.write_drive(api.home.video.with_name("new.mp4"), 6))).id)


def start_follow(api: JobApi) -> str:
    anchor = {"frame": 20, "box": toy_pipeline.sign_box(20).tolist()}  # type: ignore[union-attr]
    body = {"key": "m1", "anchors": [anchor], "first": 18, "last": 22}
    return str(api.post(f"runs/{api.home.run_id}/follows", body)["id"])


def start_training(api: JobApi) -> str:
    with api.home.reader() as reader:
        tracks = [track for track in reader.tracks() if track.confirmed]
    for track in tracks:
        for revision, command in enumerate(
            ({"name": "relabel_track", "class_id": 2}, {"name": "set_review", "review": "accepted"})
        ):
            key = f"m{track.track_id}"
            answer = api.server.client.post(
                f"/api/runs/{api.home.run_id}/edits",
                json={
                    "op_id": f"{key}-{revision}-accepted",
                    "author": "ann",
                    "command": {"key": key, "frame": track.first_frame, **command},
                },
                headers={"If-Match": f'"{key}:{revision}"'},
            )
            assert answer.status_code == 200, answer.text
    return str(api.post("models", {"reviews": [api.home.run_id], "parts": ["online"]})["id"])


START: dict[str, Callable[[JobApi], str]] = {
    "track": JobApi.start_run,
    "whatif": lambda api: api.context.whatif.start(api.run, {"tau": 4.0}).id,
    "import": start_import,
    "follow": start_follow,
    "retrain": start_training,
    "export": lambda api: api.post("exports", {"runs": [api.run], "format": "tracks-json"})["id"],
    "recording": lambda api: api.post(f"runs/{api.run}/recordings", {"first": 0, "stop": FRAMES})["id"],
    "bundle": lambda api: api.post(f"runs/{api.run}/bundles", {"first": 0, "stop": FRAMES})["id"],
    "scene": lambda api: api.post(f"runs/{api.home.run_id}/scenes", {"mode": "drive"})["id"],
}
"""Kind of job -> starts one and returns its subject."""


def cancel(api: JobApi, kind: str, subject: str) -> None:
    """Cancel as a person does; nobody can cancel an import that is running, so its flag is set."""
    c = api.context
    match kind:
        case "track" | "whatif":
            c.runs.cancel(subject)
        case "retrain":
            c.training.cancel(subject)
        case "follow":
            c.follows.drop(subject)
        case "import":
            with c.database.write() as session:
                c.jobs.cancel(session, subject)
        case _:
            c.outputs.cancel(subject)


@pytest.mark.parametrize("kind", [kind.name for kind in KINDS])
def test_a_job_that_is_cancelled_at_its_end_is_cancelled(
    api: JobApi, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    subject = START[kind](api)
    task = api.claimed(subject)
    assert task.job.kind == kind
    ends: list[str] = []
    complete = TaskContext.complete

    def cancelled_before(task: TaskContext, **options: Any) -> Any:
        ends.append(task.job.kind)
        cancel(api, kind, subject)
        return complete(task, **options)

    with monkeypatch.context() as patch:
        patch.setattr(TaskContext, "complete", cancelled_before)
        execute(task, KINDS)
    assert ends == [kind], "its task ends with the transaction that asks whether it is cancelled"
    assert "complete" not in api.states(subject)
    if kind != "follow":
        assert api.row(Job, task.job.id).state == "cancelled"
    CHECK_LEFTOVERS[kind](api, subject)


def check_run(api: JobApi, subject: str) -> None:
    run = api.row(Run, subject)
    assert (run.state, run.tracks, run.summary, run.finished) == ("cancelled", None, {}, None)
    assert api.states(subject)[-1] == "cancelled"


def check_track(api: JobApi, subject: str) -> None:
    """All frames stay as evidence, and the run can be resumed."""
    check_run(api, subject)
    with EvidenceReader(api.context.settings.home / api.row(Run, subject).folder) as reader:
        assert len(reader) == FRAMES
    api.context.runs.resume(subject)
    run_jobs(api.context, "track")
    run = api.row(Run, subject)
    assert (run.state, run.frames_done) == ("complete", FRAMES)


def check_import(api: JobApi, subject: str) -> None:
    video = api.row(Video, subject)
    assert (video.state, video.width, video.duration) == ("failed", None, None)
    assert "The import was stopped" in video.error
    assert api.states(subject)[-1] == "failed"


def check_follow(api: JobApi, subject: str) -> None:
    """A follow that was dropped is gone."""
    assert api.row(Follow, subject) is None
    assert api.rows(select(Job).where(Job.subject == subject)) == []
    assert api.rows(select(FollowPiece).where(FollowPiece.follow_id == subject)) == []


def check_training(api: JobApi, subject: str) -> None:
    version = api.row(ModelVersion, subject)
    assert (version.state, version.models, version.figures) == ("cancelled", {}, {})
    assert api.states(subject)[-1] == "cancelled"
    assert not (api.context.settings.home / "models" / subject).exists()
    assert not (api.context.settings.home / "models" / f"{subject}.work").exists()


def check_output(api: JobApi, subject: str) -> None:
    output = api.row(Output, subject)
    assert (output.state, output.path, output.size, output.sha256) == ("cancelled", "", None, "")
    assert api.states(subject)[-1] == "cancelled"
    assert not output_folder(api.context.settings.home, subject).exists()


CHECK_LEFTOVERS: dict[str, Callable[[JobApi, str], None]] = {
    "track": check_track,
    "whatif": check_run,
    "import": check_import,
    "follow": check_follow,
    "retrain": check_training,
    **dict.fromkeys(("export", "recording", "bundle", "scene"), check_output),
}
"""Kind of job -> checks what is left of one that was cancelled at its end."""
