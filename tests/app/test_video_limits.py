"""One picture size limit for every access to videos: the server imports only what it can track and export."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from typing import Any

import pytest

from app.evidence.explainer import ExplainRequest, explain_request
from app.settings import Settings
from tests import toy_pipeline
from tests.app import toy_home
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server
from tsr_engine.errors import VideoError
from tsr_engine.io.video_limits import VideoLimits

PIXELS = toy_pipeline.WIDTH * toy_pipeline.HEIGHT
REFUSED = f"more than the limit of {PIXELS - 1} pixels"


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[toy_home.ToyHome]:
    """A video and a run made under a larger limit."""
    home = toy_home.make_home(tmp_path_factory.mktemp("limits"))
    yield home
    home.evidence.close()
    home.database.close()


def served(home: toy_home.ToyHome, most: int) -> Server:
    return Server(home.settings.home, roots=(home.video.parent,), max_pixels=most)


@pytest.fixture(scope="module")
def strict_server(home: toy_home.ToyHome) -> Iterator[Server]:
    """A server on it with a limit one pixel too small."""
    server = served(home, PIXELS - 1)
    with server.client:
        yield server


def test_there_is_one_default() -> None:
    assert Settings.model_fields["max_pixels"].default == VideoLimits().max_pixels
    assert VideoLimits().max_pixels >= 7680 * 4320


def wait_for_job(server: Server, url: str, body: dict[str, Any]) -> dict[str, Any]:
    """The final state of a requested job."""
    answer = server.client.post(url, json=body)
    assert answer.status_code == 202, answer.text
    run_jobs(server.context)
    place = {"models": "models", "runs": "runs"}.get(url.rsplit("/", 1)[-1], "outputs")
    found: dict[str, Any] = server.client.get(f"/api/{place}/{answer.json()['id']}").json()
    return found


def test_a_run_on_too_large_pictures_fails(home: toy_home.ToyHome, strict_server: Server) -> None:
    run = wait_for_job(strict_server, f"/api/videos/{home.video_id}/runs", {"stop": 4})
    assert (run["state"], REFUSED in run["error"]) == ("failed", True), run["error"]


@pytest.mark.parametrize(
    ("url", "body"),
    [
        ("/api/exports", {"format": "yolo", "pictures": "annotated", "states": ["open"]}),
        ("/api/runs/RUN/recordings", {"first": 50, "stop": 54}),
        ("/api/runs/RUN/bundles", {"first": 60, "stop": 64}),
    ],
)
def test_outputs_of_too_large_pictures_fail(
    home: toy_home.ToyHome, strict_server: Server, url: str, body: dict[str, Any]
) -> None:
    given = {**body, "runs": [home.run_id]} if url == "/api/exports" else body
    made = wait_for_job(strict_server, url.replace("RUN", home.run_id), given)
    assert (made["state"], REFUSED in (made["error"] or "")) == ("failed", True), made


def test_training_on_too_large_pictures_fails(home: toy_home.ToyHome, strict_server: Server) -> None:
    with home.reader() as reader:
        track = next(t for t in reader.tracks() if t.confirmed)
    for revision, command in enumerate(
        ({"name": "relabel_track", "class_id": 2}, {"name": "set_review", "review": "accepted"})
    ):
        body = {"key": f"m{track.track_id}", "frame": track.first_frame, **command}
        answer = strict_server.client.post(
            f"/api/runs/{home.run_id}/edits",
            json={"op_id": uuid.uuid4().hex, "author": "ann", "command": body},
            headers={"If-Match": f'"m{track.track_id}:{revision}"'},
        )
        assert answer.status_code == 200, answer.text
    export = wait_for_job(
        strict_server, "/api/exports", {"runs": [home.run_id], "format": "cvat-video", "states": ["accepted"]}
    )
    assert export["state"] == "complete", export["error"]
    version = wait_for_job(strict_server, "/api/models", {"exports": [export["id"]], "parts": ["online"]})
    assert (version["state"], REFUSED in version["error"]) == ("failed", True), version["error"]


def test_an_explanation_of_too_large_pictures_fails(
    home: toy_home.ToyHome, monkeypatch: pytest.MonkeyPatch, strict_server: Server
) -> None:
    """The process gets the limit with each request."""
    requests: list[ExplainRequest] = []
    monkeypatch.setattr(strict_server.context.pixels.explainer, "explain", requests.append)
    with home.reader() as reader:
        track = next(t for t in reader.tracks() if t.confirmed)
    strict_server.client.get(f"/api/runs/{home.run_id}/tracks/{track.track_id}/explain/{track.first_frame + 5}")
    (question,) = requests
    assert question.max_pixels == PIXELS - 1
    monkeypatch.setattr("app.evidence.explainer.pixels_in_frame", lambda *_: None)
    with pytest.raises(VideoError, match=REFUSED):
        explain_request(question)


def test_a_limit_above_the_engines_default_works(home: toy_home.ToyHome, monkeypatch: pytest.MonkeyPatch) -> None:
    """Code that does not pass on the server's limit uses the engine's, which refuses everything here."""
    for place in ("io.video", "recording.clip", "bundle.clip"):
        monkeypatch.setattr(f"tsr_engine.{place}.VideoLimits", lambda: VideoLimits(max_pixels=1))
    generous = served(home, PIXELS)
    with generous.client:
        run = wait_for_job(generous, f"/api/videos/{home.video_id}/runs", {"stop": 2})
        assert run["state"] == "complete", run["error"]
        for url, body in (
            ("/api/exports", {"format": "yolo", "pictures": "annotated", "runs": [home.run_id]}),
            (f"/api/runs/{home.run_id}/recordings", {"first": 50, "stop": 54}),
            (f"/api/runs/{home.run_id}/bundles", {"first": 60, "stop": 64}),
        ):
            made = wait_for_job(generous, url, body)
            assert made["state"] == "complete", made["error"]
