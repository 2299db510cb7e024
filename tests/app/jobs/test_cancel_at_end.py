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
from tests import pipeline_toys as toys
from tests.app.import_now import work_off
from tests.app.toy_home import ToyHome, make_home
from tests.app.toy_server import Server
from tsr_engine.evidence import EvidenceReader

FRAMES = 8
AIMED = {"coast_foe_y": 0.5}


class Desk:
    """A server on a toy home, with a complete run of the shipped models."""

    def __init__(self, home: ToyHome, server: Server) -> None:
        self.home, self.server, self.context = home, server, server.context
        self.run = self.start_run()
        work_off(self.context, "track")

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
        return self.context.runs.start(self.home.video_id, stop=FRAMES, parameters=AIMED).id

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
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    home = make_home(tmp_path_factory.mktemp("cancelled"), 80)
    server = Server(home.settings.home, roots=(home.video.parent,))
    with server.client, pytest.MonkeyPatch.context() as patch:
        patch.setattr(service, "LEASE_S", 600.0)  # no page reads its follow
        yield Desk(home, server)
    home.evidence.close()
    home.database.close()


def start_import(desk: Desk) -> str:
    return str(desk.context.videos.add_path(str(toys.write_drive(desk.home.video.with_name("new.mp4"), 6))).id)


def start_follow(desk: Desk) -> str:
    anchor = {"frame": 20, "box": toys.sign_box(20).tolist()}  # type: ignore[union-attr]
    body = {"key": "m1", "anchors": [anchor], "first": 18, "last": 22}
    return str(desk.post(f"runs/{desk.home.run_id}/follows", body)["id"])


def start_training(desk: Desk) -> str:
    with desk.home.reader() as reader:
        tracks = [track for track in reader.tracks() if track.confirmed]
    for track in tracks:
        for revision, command in enumerate(
            ({"name": "relabel_track", "class_id": 2}, {"name": "set_review", "review": "accepted"})
        ):
            key = f"m{track.track_id}"
            answer = desk.server.client.post(
                f"/api/runs/{desk.home.run_id}/edits",
                json={
                    "op_id": f"{key}-{revision}-accepted",
                    "author": "ann",
                    "command": {"key": key, "frame": track.first_frame, **command},
                },
                headers={"If-Match": f'"{key}:{revision}"'},
            )
            assert answer.status_code == 200, answer.text
    return str(desk.post("models", {"reviews": [desk.home.run_id], "parts": ["online"]})["id"])


START: dict[str, Callable[[Desk], str]] = {
    "track": Desk.start_run,
    "whatif": lambda desk: desk.context.whatif.start(desk.run, {"tau": 4.0}).id,
    "import": start_import,
    "follow": start_follow,
    "retrain": start_training,
    "export": lambda desk: desk.post("exports", {"runs": [desk.run], "format": "tracks-json"})["id"],
    "recording": lambda desk: desk.post(f"runs/{desk.run}/recordings", {"first": 0, "stop": FRAMES})["id"],
    "bundle": lambda desk: desk.post(f"runs/{desk.run}/bundles", {"first": 0, "stop": FRAMES})["id"],
    "scene": lambda desk: desk.post(f"runs/{desk.home.run_id}/scenes", {"mode": "drive"})["id"],
}
"""Kind of job -> starts one and returns its subject."""


def cancel(desk: Desk, kind: str, subject: str) -> None:
    """Cancel as a person does; nobody can cancel an import that is running, so its flag is set."""
    c = desk.context
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
    desk: Desk, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    subject = START[kind](desk)
    task = desk.claimed(subject)
    assert task.job.kind == kind
    ends: list[str] = []
    complete = TaskContext.complete

    def cancelled_before(task: TaskContext, **options: Any) -> Any:
        ends.append(task.job.kind)
        cancel(desk, kind, subject)
        return complete(task, **options)

    with monkeypatch.context() as patch:
        patch.setattr(TaskContext, "complete", cancelled_before)
        execute(task)
    assert ends == [kind], "its task ends with the transaction that asks whether it is cancelled"
    assert "complete" not in desk.states(subject)
    if kind != "follow":
        assert desk.row(Job, task.job.id).state == "cancelled"
    LEFT[kind](desk, subject)


def left_of_run(desk: Desk, subject: str) -> None:
    run = desk.row(Run, subject)
    assert (run.state, run.tracks, run.summary, run.finished) == ("cancelled", None, {}, None)
    assert desk.states(subject)[-1] == "cancelled"


def left_of_track(desk: Desk, subject: str) -> None:
    """All frames stay as evidence, and the run can be resumed."""
    left_of_run(desk, subject)
    with EvidenceReader(desk.context.settings.home / desk.row(Run, subject).folder) as reader:
        assert len(reader) == FRAMES
    desk.context.runs.resume(subject)
    work_off(desk.context, "track")
    run = desk.row(Run, subject)
    assert (run.state, run.frames_done) == ("complete", FRAMES)


def left_of_import(desk: Desk, subject: str) -> None:
    video = desk.row(Video, subject)
    assert (video.state, video.width, video.duration) == ("failed", None, None)
    assert "The import was stopped" in video.error
    assert desk.states(subject)[-1] == "failed"


def left_of_follow(desk: Desk, subject: str) -> None:
    """A follow that was dropped is gone."""
    assert desk.row(Follow, subject) is None
    assert desk.rows(select(Job).where(Job.subject == subject)) == []
    assert desk.rows(select(FollowPiece).where(FollowPiece.follow_id == subject)) == []


def left_of_training(desk: Desk, subject: str) -> None:
    version = desk.row(ModelVersion, subject)
    assert (version.state, version.models, version.figures) == ("cancelled", {}, {})
    assert desk.states(subject)[-1] == "cancelled"
    assert not (desk.context.settings.home / "models" / subject).exists()
    assert not (desk.context.settings.home / "models" / f"{subject}.work").exists()


def left_of_output(desk: Desk, subject: str) -> None:
    output = desk.row(Output, subject)
    assert (output.state, output.path, output.size, output.sha256) == ("cancelled", "", None, "")
    assert desk.states(subject)[-1] == "cancelled"
    assert not output_folder(desk.context.settings.home, subject).exists()


LEFT: dict[str, Callable[[Desk, str], None]] = {
    "track": left_of_track,
    "whatif": left_of_run,
    "import": left_of_import,
    "follow": left_of_follow,
    "retrain": left_of_training,
    **dict.fromkeys(("export", "recording", "bundle", "scene"), left_of_output),
}
"""Kind of job -> checks what is left of one that was cancelled at its end."""
