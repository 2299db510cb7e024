"""Lone surrogates and NUL in every text of a request are refused or stored, never an internal error."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from app.api.request_body import safe_name
from tests.app import toy_home
from tests.app.databases import new_database
from tests.app.toy_server import Server

JSON = {"Content-Type": "application/json"}


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def toy(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[toy_home.ToyHome]:
    """One tracked toy drive on each kind of database."""
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "postgresql":
            patch.setenv("TSR_DATABASE_URL", new_database(request.getfixturevalue("cluster")))
        home = toy_home.make_home(tmp_path_factory.mktemp("hostile"))
        yield home
        home.evidence.close()
        home.database.close()


@pytest.fixture(scope="module")
def server(toy: toy_home.ToyHome) -> Iterator[Server]:
    """A server on it."""
    server = Server(toy.settings.home, roots=(toy.video.parent,))
    with server.client:
        yield server


def edit(command: str, author: str = "x") -> tuple[str, str]:
    return "/api/runs/RUN/edits", f'{{"op_id": "aaaaaaaa", "author": "{author}", "command": {{{command}}}}}'


ON = '"frame": 5, "key": "m1"'
BODIES = [
    ("/api/videos", '{"path": "/aBAD"}'),
    ("/api/videos", '{"path": "/a", "BAD": 1}'),
    ("/api/videos/VIDEO/runs", '{"name": "xBAD"}'),
    ("/api/videos/VIDEO/runs", '{"preset": "xBAD"}'),
    ("/api/videos/VIDEO/runs", '{"parameters": {"xBAD": 1}}'),
    ("/api/videos/VIDEO/runs", '{"parameters": {"tau": "BAD"}}'),
    ("/api/runs/RUN/whatif", '{"parameters": {"tau": 5.0}, "name": "xBAD"}'),
    ("/api/runs/RUN/whatif", '{"parameters": {"BAD": 5.0}}'),
    ("/api/runs/RUN/adopt", '{"from_run": "RUN", "author": "xBAD"}'),
    edit(f'"name": "delete_track", {ON}', author="xBAD"),
    edit(f'"name": "add_note", {ON}, "note_id": "n", "text": "xBAD"'),
    edit(f'"name": "add_note", {ON}, "note_id": "BAD", "text": "x"'),
    edit('"name": "undo", "op_id": "aaaaaaaaBAD"'),
    edit('"name": "BAD"'),
]


@pytest.mark.parametrize("bad", [r"\ud800", r"\u0000", r"\udc00x"])
@pytest.mark.parametrize(("path", "body"), BODIES)
def test_bodies_with_hostile_text_are_refused(
    server: Server, toy: toy_home.ToyHome, path: str, body: str, bad: str
) -> None:
    # NUL is valid text, but is refused in a path
    status = 403 if bad == r"\u0000" and "/aBAD" in body else 422
    path, body = (text.replace("VIDEO", toy.video_id).replace("RUN", toy.run_id) for text in (path, body))
    content = body.replace("BAD", bad).encode()
    answer = server.client.post(path, content=content, headers={**JSON, "If-Match": '"m1:0"'})
    assert answer.status_code == status, (answer.status_code, answer.text)
    assert answer.json()["error"]["message"].endswith(".")
    assert server.client.get(f"/api/runs/{toy.run_id}/edits").json() == {"edits": []}


@pytest.mark.parametrize("path", ["/api/videos/VIDEO/runs", "/api/runs/RUN/whatif"])
@pytest.mark.parametrize(
    ("name", "value", "field", "words"),
    [
        ("tau", "true", "parameters.tau", "gate.tau: must not be true or false"),
        ("search_scales", "[true]", "parameters.search_scales", "online.search_scales: must not be true or false"),
        ("tau", "NaN", "parameters.tau", "gate.tau: Input should be a finite number. Got nan"),
        ("tau", "1e400", "parameters.tau", "gate.tau: Input should be a finite number. Got inf"),
        ("search_scales", "[NaN]", "parameters.search_scales", "finite number"),
        ("tau", "{}", "parameters.tau", "parameters.tau: must be a number, a list of numbers, text"),
        ("tau", '["x"]', "parameters.tau", "parameters.tau: must be a number, a list of numbers, text"),
    ],
)
def test_hostile_parameter_values_are_refused(
    server: Server, toy: toy_home.ToyHome, path: str, name: str, value: str, field: str, words: str
) -> None:
    path = path.replace("VIDEO", toy.video_id).replace("RUN", toy.run_id)
    body = f'{{"parameters": {{"{name}": {value}}}}}'.encode()
    answer = server.client.post(path, content=body, headers=JSON)
    error = answer.json()["error"]
    assert (answer.status_code, error["field"]) == (422, field), answer.text
    assert words in error["message"]


def test_long_names_of_files_are_cut_before_their_extension(server: Server) -> None:
    assert safe_name(f"{'x' * 200}.zip", "import").endswith("x.zip")
    headers, query = {"Content-Type": "application/octet-stream"}, {"name": "\u8def" * 110 + ".names"}
    answer = server.client.post("/api/label-sets/gtsrb-43/files", params=query, content=b"stop\n", headers=headers)
    assert answer.status_code == 200, answer.text


@pytest.mark.parametrize("bad", ["%00", "%ed%a0%80", "%ff", "%c0%80"])
def test_urls_with_hostile_text_are_refused(server: Server, toy: toy_home.ToyHome, bad: str) -> None:
    for path in (
        f"/api/runs/{toy.run_id}/annotation?author={bad}",
        f"/api/browse?path=/{bad}",
        f"/api/videos/{bad}",
        f"/api/runs/{bad}",
        f"/static/{bad}",
        f"/login/{bad}",
        f"/{bad}",
    ):
        assert server.client.get(path).status_code < 500, path
    for path in (f"/api/uploads/{bad}.mp4", f"/api/videos/{toy.video_id}/ground-truths/{bad}"):
        assert server.client.put(path, content=b"x").status_code < 500, path
    assert server.client.get("/api/events", params={"after": "x"}).status_code == 422
