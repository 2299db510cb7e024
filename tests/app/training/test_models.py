"""The loop over HTTP on a toy drive: accept, export, retrain, promote, run, roll back."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from app.exchange.retrain_task import export_reviews
from app.jobs.context import Stopped, TaskContext
from app.jobs.outcome import end_stopped_task, report_failure
from app.storage.models import Job, ModelVersion, Run, Video
from app.training.folders import models_for_start, models_of_run
from app.training.task import retrain_models
from tests.app import toy_home
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server
from tests.app.training.training_client import TrainingClient
from tsr_engine.detection.acf import AcfModel
from tsr_engine.detection.prior import SpatialPrior
from tsr_engine.errors import ModelError
from tsr_engine.io.models import SHIPPED, component_path, load_component, read_manifest
from tsr_engine.training.corrections import retrain
from tsr_engine.training.corrections.corrected_scenes import CorrectedScene
from tsr_engine.training.corrections.holdout import evaluate_detection
from tsr_engine.training.progress import Progress


@pytest.fixture(scope="module")
def api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TrainingClient]:
    home = toy_home.make_home(tmp_path_factory.mktemp("training"), 80)
    server = Server(home.settings.home, roots=(home.settings.home,))
    with server.client:
        made = TrainingClient(home, server)
        made.accept()
        yield made
    home.evidence.close()
    home.database.close()


@pytest.fixture(scope="module")
def export(api: TrainingClient) -> str:
    return api.export(states=["accepted"])


@pytest.fixture(scope="module")
def version(api: TrainingClient, export: str) -> dict[str, Any]:
    return api.train(name="First", exports=[export], parts=["prior", "classifier", "online"], seed=3)


@pytest.fixture
def quick_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Detection is measured on one held-out frame, where a test is not about figures."""

    def evaluate_one(
        model: AcfModel, prior: SpatialPrior | None, scenes: Sequence[CorrectedScene], tick: Progress
    ) -> Any:
        return evaluate_detection(model, prior, scenes[:1], tick)

    monkeypatch.setattr(retrain, "evaluate_detection", evaluate_one)


def test_a_version_stores_its_origin(api: TrainingClient, export: str, version: dict[str, Any]) -> None:
    assert version["state"] == "complete", version["error"]
    assert (version["parent_id"], version["name"], version["active"]) == (None, "First", False)
    lineage = version["lineage"]
    assert lineage["asked"]["exports"][0]["artefact"] == export
    assert lineage["exports"][0]["sha256"] == lineage["asked"]["exports"][0]["sha256"]
    assert lineage["exports"][0]["runs"][0]["edit_revision"] > 0
    assert lineage["parent"]["models"]["detector"] == load_component("detector").sha256
    assert (lineage["seed"], lineage["parts"]) == (3, ["prior", "classifier", "online"])
    assert lineage["used"]["signs"] == 2


@pytest.mark.usefixtures("quick_figures")
def test_training_on_the_current_review_gives_the_same_and_stores_its_revision(
    api: TrainingClient, version: dict[str, Any]
) -> None:
    found = api.train(name="Reviewed", reviews=[api.home.run_id], parts=["prior"], seed=3)
    assert found["state"] == "complete", found["error"]
    lineage = found["lineage"]
    assert lineage["asked"]["reviews"] == [{"run": api.home.run_id, "video": api.home.video_id, "name": "drive.mp4"}]
    (about,) = lineage["exports"]
    (source,) = api.client.get("/api/models/sources").json()["reviews"]
    assert (about["name"], about["names"]) == ("Present review", ["drive.mp4"])
    assert about["runs"][0]["edit_revision"] == source["edit_revision"] > 0
    assert lineage["used"]["signs"] == version["lineage"]["used"]["signs"]
    assert (source["video_name"], source["accepted"], source["rejected"], source["left"]) == ("drive.mp4", 2, 0, 0)


@pytest.mark.parametrize(
    ("body", "status", "words"),
    [({"reviews": ["0" * 32]}, 404, "There is no run"), ({"reviews": []}, 422, "Name at least one reviewed run")],
)
def test_reviews_without_training_data_are_refused(
    api: TrainingClient, body: dict[str, Any], status: int, words: str
) -> None:
    answer = api.ask(**body)
    assert answer.status_code == status
    assert words in answer.json()["error"]["message"]


def test_a_version_is_complete_with_untrained_parts_of_its_parent(api: TrainingClient, version: dict[str, Any]) -> None:
    folder = api.home.settings.home / "models" / version["id"]
    assert {name: load_component(name, folder).sha256 for name in version["models"]} == version["models"]
    shipped = {name: entry["sha256"] for name, entry in read_manifest(SHIPPED)["components"].items()}
    assert version["models"]["detector"] == shipped["detector"]
    assert version["models"]["classifier"] != shipped["classifier"]
    made = {one["id"] for one in api.client.get("/api/models").json()["models"]}
    assert {p.name for p in folder.parent.iterdir()} <= made  # no partial file is left


def test_figures_are_shown_beside_those_of_the_parent(version: dict[str, Any]) -> None:
    found = version["figures"]["corrections"]
    assert found["by"] == "sign"
    assert found["signs"] == 1
    assert set(found["new"]) == set(found["parent"]) >= {"ap50", "crops_right", "signs_right"}
    assert set(version["figures"]["remembered"]["new"]) == {"signs_kept", "others_kept", "crops_kept"}
    assert isinstance(version["figures"]["worse"], list)


def test_promote_run_roll_back(api: TrainingClient, version: dict[str, Any]) -> None:
    settings = api.home.settings
    assert api.active() == "shipped"
    assert api.client.post("/api/models/rollback").status_code == 409
    before = api.home.add_run(state="queued", models={}, folder="runs/none")
    with api.home.database.write() as session:
        assert models_for_start(settings, session, session.get_one(Run, before)) is None
    answer = api.client.post(f"/api/models/{version['id']}/promote")
    assert answer.status_code == 200
    assert answer.json()["active"]
    assert api.active() == version["id"]

    started = api.client.post(f"/api/videos/{api.home.video_id}/runs", json={"stop": 3}).json()
    run_jobs(api.server.context, "track")
    run = api.client.get(f"/api/runs/{started['id']}").json()
    assert run["state"] == "complete", run["error"]
    assert run["models"] == {name: version["models"][name] for name in run["models"]}
    assert run["models"]["classifier"] == version["models"]["classifier"]

    with api.home.database.write() as session:  # a run started before the promotion keeps its models
        assert models_for_start(settings, session, session.get_one(Run, before)) is None
        assert models_of_run(settings, session, session.get_one(Run, started["id"])) == (
            settings.home / "models" / version["id"]
        )
    removed = api.client.delete(f"/api/models/{version['id']}")
    assert removed.status_code == 409
    assert api.client.post("/api/models/rollback").json()["id"] == "shipped"
    assert api.active() == "shipped"
    with api.home.database.write() as session:  # like a run that did not use all components of its version
        row = session.get_one(Run, started["id"])
        row.models = {name: digest for name, digest in row.models.items() if name != "online"}
    removed = api.client.delete(f"/api/models/{version['id']}")
    assert (removed.status_code, removed.json()["error"]["code"]) == (409, "in_use")


def test_damaged_versions_are_refused(api: TrainingClient, version: dict[str, Any]) -> None:
    folder = api.home.settings.home / "models" / version["id"]
    file = component_path("classifier", folder)
    content = file.read_bytes()
    try:
        file.write_bytes(content[:-7] + b"garbage")
        answer = api.client.post(f"/api/models/{version['id']}/promote")
        assert (answer.status_code, answer.json()["error"]["code"]) == (409, "damaged")
        run = api.home.add_run(state="queued", models=dict(version["models"]), folder="runs/damaged", stop=2)
        with api.home.database.write() as session:
            api.server.context.jobs.submit(session, "track", run)
        run_jobs(api.server.context, "track")
        with api.home.database.read() as session:
            row = session.get_one(Run, run)
            assert row.state == "failed"
            assert "does not match its manifest" in str(row.error)
            session.expunge_all()
    finally:
        file.write_bytes(content)
    gone = api.home.add_run(models={"detector": "0" * 64}, name="Old run")
    said = "Old run was started with models .* --models and their folder"
    with api.home.database.read() as session, pytest.raises(ModelError, match=said):
        models_of_run(api.home.settings, session, session.get_one(Run, gone))


@pytest.mark.parametrize(
    ("body", "status", "words"),
    [
        ({}, 422, "at least one reviewed run"),
        ({"exports": ["0" * 32]}, 404, "no export"),
        ({"exports": ["0" * 32], "parts": ["wheels"]}, 422, ""),
        ({"folders": {"gtsdb": "/etc"}}, 403, "outside the folders"),
        ({"exports": ["0" * 32], "parent": "1" * 32}, 422, "to start from"),
        ({"exports": ["0" * 32], "name": "Shipped"}, 422, "'Shipped' names the models without any training"),
    ],
)
def test_invalid_requests_are_refused(api: TrainingClient, body: dict[str, Any], status: int, words: str) -> None:
    answer = api.ask(**body)
    assert answer.status_code == status, answer.text
    assert words in answer.json()["error"]["message"]


def test_an_incomplete_export_is_refused(api: TrainingClient) -> None:
    waiting = api.client.post("/api/exports", json={"runs": [api.home.run_id], "format": "cvat-video"}).json()["id"]
    answer = api.ask(exports=[waiting])
    assert (answer.status_code, answer.json()["error"]["code"]) == (409, "not_complete")
    api.client.post(f"/api/outputs/{waiting}/cancel")


def _claim(api: TrainingClient, version: str, leaving: bool) -> TaskContext:
    context = api.server.context
    with context.database.write() as session:
        job_id = next(j for j in context.jobs.waiting_ids(session) if session.get_one(Job, j).subject == version)
        job = context.jobs.claim(session, job_id)
    assert job is not None
    return TaskContext(context.settings, context.database, context.events, context.jobs, job, lambda: leaving)


@pytest.mark.usefixtures("quick_figures")
def test_stopped_training_is_requeued_and_killed_training_restarts(api: TrainingClient, export: str) -> None:
    made = api.ask(exports=[export], parts=["online"], name="Again").json()["id"]
    task = _claim(api, made, leaving=True)
    with pytest.raises(Stopped):
        retrain_models(task, export_reviews)
    end_stopped_task(task)
    assert api.view(made)["state"] == "queued"

    models = api.home.settings.home / "models"  # as left by a killed process
    for suffix in (".part", ".work"):
        (models / f"{made}{suffix}").mkdir(exist_ok=True)
        (models / f"{made}{suffix}" / "rubbish").write_text("x")
    run_jobs(api.server.context, "retrain")
    assert api.view(made)["state"] == "complete", api.view(made)["error"]
    assert not list(models.glob(f"{made}.*"))
    assert not (models / made / "rubbish").exists()
    assert api.client.delete(f"/api/models/{made}").status_code == 204
    assert not (models / made).exists()


def test_a_training_that_is_killed_too_often_leaves_no_pictures(api: TrainingClient, export: str) -> None:
    made = api.ask(exports=[export], parts=["online"], name="Killed").json()["id"]
    task = _claim(api, made, leaving=False)
    models = api.home.settings.home / "models"
    for suffix in (".part", ".work"):  # as left by a killed process
        (models / f"{made}{suffix}" / "v000").mkdir(parents=True)
    report_failure(task, "The worker was killed several times.")
    assert api.view(made)["state"] == "failed"
    assert [path.name for path in models.glob(f"{made}*")] == [f"{made}.part"], "finished parts are kept"
    assert api.client.delete(f"/api/models/{made}").status_code == 204


def test_cancel_and_resume(api: TrainingClient, export: str) -> None:
    made = api.ask(exports=[export], parts=["online"], name="Third").json()["id"]
    assert api.client.post(f"/api/models/{made}/cancel").json()["state"] == "cancelled"
    assert api.client.post(f"/api/models/{made}/resume").json()["state"] == "queued"
    assert api.client.post(f"/api/models/{made}/resume").status_code == 409
    task = _claim(api, made, leaving=False)
    assert api.client.post(f"/api/models/{made}/cancel").status_code == 202
    with pytest.raises(Stopped):
        retrain_models(task, export_reviews)
    end_stopped_task(task)
    assert api.view(made)["state"] == "cancelled"
    assert api.client.delete(f"/api/models/{made}").status_code == 204


@pytest.mark.usefixtures("quick_figures")
def test_a_version_that_is_no_longer_active_can_be_removed(api: TrainingClient, export: str) -> None:
    first, second = (api.train(exports=[export], parts=["online"], seed=seed)["id"] for seed in (8, 9))
    for made in (first, second):
        assert api.client.post(f"/api/models/{made}/promote").status_code == 200
    answer = api.client.delete(f"/api/models/{second}")
    assert answer.status_code == 409
    assert "is active. Promote another version, or roll back." in answer.text
    assert api.client.delete(f"/api/models/{first}").status_code == 204
    assert api.client.post("/api/models/rollback").json()["id"] == "shipped"
    assert api.client.delete(f"/api/models/{second}").status_code == 204


@pytest.mark.usefixtures("quick_figures")
def test_a_version_can_start_from_another(api: TrainingClient, export: str, version: dict[str, Any]) -> None:
    child = api.train(exports=[export], parts=["online"], parent=version["id"])
    assert child["state"] == "complete", child["error"]
    assert child["parent_id"] == version["id"]
    assert child["models"]["classifier"] == version["models"]["classifier"]
    assert child["models"]["online"] != version["models"]["online"]


def test_a_missing_export_fails_with_a_sentence(api: TrainingClient) -> None:
    lost = api.export(states=["accepted"])
    made = api.ask(exports=[lost], parts=["online"]).json()["id"]
    shutil.rmtree(api.home.settings.home / "artefacts" / lost)
    run_jobs(api.server.context, "retrain")
    assert api.view(made)["state"] == "failed"
    assert "There is no export at" in api.view(made)["error"]


@pytest.mark.usefixtures("quick_figures")
def test_a_changed_video_is_not_used_for_training(api: TrainingClient, export: str) -> None:
    """The size is the same; only the digest differs."""
    with api.home.database.read() as session:
        path = Path(session.get_one(Video, api.home.video_id).path)
    content, status = path.read_bytes(), path.stat()
    try:
        path.write_bytes(content[:-1] + bytes([content[-1] ^ 1]))
        os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns + 10**9))
        version = api.train(exports=[export], parts=["online"])
        assert version["state"] == "failed"
        assert f"{path} has changed since it was added and was not used for training" in version["error"]
        name = version["lineage"]["asked"]["exports"][0]["name"]
        assert f"{name}: the file of drive.mp4 is missing" in version["error"]

        path.write_bytes(content)
        os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns + 2 * 10**9))
        assert api.train(exports=[export], parts=["online"])["state"] == "complete", "touched, the same bytes"
    finally:
        path.write_bytes(content)
        os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


def test_the_command_line_lists_the_same_versions(
    api: TrainingClient, version: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    from app.cli.main import run

    home = ["--home", str(api.home.settings.home)]
    assert run(["models", "list", *home]) == 0
    assert "First" in capsys.readouterr().out
    assert run(["models", "promote", "First", *home]) == 0
    assert api.active() == version["id"]
    assert run(["models", "promote", "Nobody", *home]) == 2
    assert "there is no version" in capsys.readouterr().err
    assert run(["models", "rollback", *home]) == 0
    assert run(["models", "rollback", *home]) == 2
    _rename(api, version["id"], "shipped")
    assert run(["models", "promote", version["id"], *home]) == 0
    assert run(["models", "promote", "shipped", *home]) == 0
    assert api.active() == "shipped", "the id counts before the name, which versions of earlier servers may have"
    _rename(api, version["id"], "First")
    with api.home.database.read() as session:
        assert all(v.promoted == 0 for v in session.query(ModelVersion))


def _rename(api: TrainingClient, version: str, name: str) -> None:
    with api.home.database.write() as session:
        session.get_one(ModelVersion, version).name = name
