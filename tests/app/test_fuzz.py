"""The server keeps its OpenAPI document: valid and invalid requests on a data folder with a real run.

``TSR_FUZZ=N`` tries N random requests per route and phase instead of the few in every test run; ``make test-long`` sets
it.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import jsonschema_rs
import pytest
import requests
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis.errors import Unsatisfiable
from schemathesis.checks import load_all_checks
from schemathesis.config import GenerationConfig, ProjectConfig, ProjectsConfig, SchemathesisConfig
from schemathesis.core.failures import FailureGroup
from schemathesis.generation import GenerationMode
from schemathesis.schemas import BaseSchema
from schemathesis.specs.openapi.checks import positive_data_acceptance, response_schema_conformance

from app.labels.store import SET_KEY
from tests.app import toy_home
from tests.app.threaded_server import ThreadedServer, serve_in_thread
from tests.app.toy_server import SECRET, Server

_MOST = int(os.environ.get("TSR_FUZZ", "0"))
_DESTROYS = ("DELETE",)
_ENDLESS = ("follow_events",)
_STRICTER = frozenset(
    {
        "add_video",  # the path must be absolute
        "browse",  # the path must be one
        "upload_video",  # the bytes must be a video's
        "start_run",  # parameters are the engine's
        "start_whatif",
        "expect_follow",  # a whole number is a whole number, not 7.0
        "start_follow",  # boxes have x1 < x2, anchors lie in frames of their own
        "get_overlays",  # last is not before first, nor far behind
        "get_truth_boxes",
        "put_truth",  # the body must be the CSV
        "give_second_opinions",  # the person exists
        "answer_second_opinion",  # the look was given to whoever answers
        "create_assignments",  # the person exists, the frames lie in the video
        "edit",  # x1 < x2, the track must exist ...
        "adopt_edits",  # from another run of the same video
        "search",  # labels exist, the smallest is below the largest, the cursor is one of this search
        "get_search_crop",  # a box is x1,y1,x2,y2 with x1 < x2 and y1 < y2
        "get_frame_crop",
        "act_on_tracks",  # the label exists
        "take_over",  # signs are named, or a label
        "find_videos",  # an answer is one to an attribute
        "start_export",  # options are the format's, runs are of different videos
        "bring_label_file",  # the body must be a file of labels
        "change_label_set",  # labels exist, names are plain text, pictures are PNG
        "get_label_file",  # the version exists
        "get_label_set",
        "use_label_set",  # the set exists
        "use_label_set_in_video",
        "train_models",  # there must be something to learn from, folders lie inside the roots
        "record_run",  # whole numbers are whole numbers; the frames must be the run's
        "bundle_run",  # the frames and tracks must be the run's
        "import_bundle",  # the body must be a bundle
        "import_file",  # the body must be of the format, switches and label_map are JSON
    }
)
"""Routes with rules that JSON Schema cannot say."""
_ID = re.compile("[0-9a-f]{32}")
_NAMED = {"run_id": _ID, "truth_id": _ID, "video_id": re.compile("[0-9a-f]{64}"), "key": re.compile(SET_KEY)}
_TRUTH = "frame,track_id,x1,y1,x2,y2,class_id,visibility,ignore\n0,1,10,20,30,40,14,1,0\n"
_FRAMES = 75
_SMALL = {"track_id": 9, "label_id": 42, "ordinal": _FRAMES, "frame": _FRAMES, "first": _FRAMES, "last": _FRAMES}
"""Numbers that the generator draws from the whole range; most of a random request's should exist, see ``small``."""


@dataclass
class ServedLibrary:
    """A server on a port, the names of its content, and validators of its answers by their schema as JSON."""

    server: ThreadedServer
    names: dict[str, str]
    validators: dict[str, jsonschema_rs.Validator] = field(default_factory=dict)

    def get(self, path: str) -> requests.Response:
        """A response with credentials."""
        return requests.get(self.server.url + path, headers={"Authorization": f"Bearer {SECRET}"}, timeout=30)


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedLibrary]:
    """A server with one imported video and one complete run."""
    home = toy_home.make_home(tmp_path_factory.mktemp("fuzz"))
    other = home.add_run(folder=f"runs/{home.run_id}", name="Run 2", parent_id=None)
    home.evidence.close()
    home.database.close()
    server = Server(home.settings.home, roots=(home.video.parent,))
    with serve_in_thread(server) as made:
        path = f"/api/videos/{home.video_id}/ground-truths/drawn"
        answer = requests.put(
            made.url + path, data=_TRUTH, headers={"Authorization": f"Bearer {SECRET}", "Content-Type": "text/csv"}
        )
        names = {
            "key": "gtsrb-43",
            "run_id": home.run_id,
            "video_id": home.video_id,
            "truth_id": answer.json()["id"],
            "from_run": other,
        }
        yield ServedLibrary(made, names)


@pytest.fixture(scope="module")
def document(served: ServedLibrary) -> BaseSchema:
    project = ProjectConfig(headers={"Authorization": f"Bearer {SECRET}"}, generation=GenerationConfig(no_shrink=True))
    raw = served.get("/api/openapi.json").json()
    load_all_checks()
    return schemathesis.openapi.from_dict(raw, config=SchemathesisConfig(projects=ProjectsConfig(default=project)))


@pytest.mark.slow
@pytest.mark.parametrize("mode", list(GenerationMode), ids=lambda mode: mode.value)
def test_every_route_follows_the_document(served: ServedLibrary, document: BaseSchema, mode: GenerationMode) -> None:
    failures: list[str] = []
    tried = 0
    for found in document.get_all_operations():
        operation = found.ok()
        if operation.definition.raw["operationId"] in _ENDLESS:
            continue
        try:
            tried += try_route(served, document, operation, mode)
        except Unsatisfiable:  # a route without parameters cannot get an invalid request
            assert mode is GenerationMode.NEGATIVE
        except (FailureGroup, AssertionError) as failure:
            failures.append(f"{operation.label}: {failure}\n{reported(failure)}")
    assert not failures, "\n\n".join(failures)
    assert tried > 200


def try_route(served: ServedLibrary, document: BaseSchema, operation: Any, mode: GenerationMode) -> int:
    """Send requests to one route; returns their number."""
    raw = operation.definition.raw
    name = raw["operationId"]
    left_out = [response_schema_conformance, *([positive_data_acceptance] if name in _STRICTER else [])]
    tried = 0

    @settings(
        max_examples=_MOST or 3,
        deadline=None,
        derandomize=not _MOST,
        suppress_health_check=list(HealthCheck),
        database=None,
        phases=[Phase.generate],
    )
    @given(case=operation.as_strategy(generation_mode=mode))
    def keeps(case: schemathesis.Case) -> None:
        nonlocal tried
        tried += 1
        made_real(case, served.names)
        if name == "edit" and mode is GenerationMode.POSITIVE:
            on_real_tracks(case, served)
        response = case.call_and_validate(base_url=served.server.url, timeout=60, excluded_checks=left_out)
        check_body(served, document.raw_schema, raw, response)
        if response.status_code >= 400:
            error = response.json()["error"]
            assert set(error) == {"code", "message", "field", "details"}
            assert error["message"].strip().endswith((".", "?")), error["message"]

    keeps()
    return tried


def check_body(served: ServedLibrary, document: Any, operation: Any, response: Any) -> None:
    """Check a JSON answer by the document. (Schemathesis would translate ``prefixItems`` into an invalid schema.)"""
    content = operation["responses"][str(response.status_code)].get("content", {})
    if "application/json" not in content or "json" not in str(response.headers["content-type"]):
        return
    schema = content["application/json"]["schema"]
    if (key := json.dumps(schema)) not in served.validators:
        complete = {**schema, "components": document["components"]}
        served.validators[key] = jsonschema_rs.Draft202012Validator(complete)
    wrong = [f"{list(e.instance_path)}: {e.message}" for e in served.validators[key].iter_errors(response.json())]
    assert not wrong, (operation["operationId"], wrong[:3])


def reported(failure: BaseException) -> str:
    """The single errors of a group."""
    return "\n".join(f"  {one}" for one in getattr(failure, "exceptions", ()))


def made_real(case: schemathesis.Case, names: dict[str, str]) -> None:
    """Replace drawn ids by existing ones, to try more than 404."""
    for name, form in _NAMED.items():
        drawn = str((case.path_parameters or {}).get(name, ""))
        if form.fullmatch(drawn) and case.method not in _DESTROYS and ord(drawn[-1]) % 8:
            case.path_parameters[name] = names[name]
    for side in ("reference", "candidate"):
        if re.fullmatch(f"(run|annotation|truth):{_ID.pattern}", str((case.query or {}).get(side))):
            kind = case.query[side].partition(":")[0]
            case.query[side] = f"{kind}:{names['truth_id' if kind == 'truth' else 'run_id']}"
    if isinstance(case.body, dict) and _ID.fullmatch(str(case.body.get("from_run"))):
        case.body["from_run"] = names["from_run"]
    for place in (case.path_parameters, case.query):
        for name, most in _SMALL.items():
            if place and name in place:
                place[name] = small(place[name], most)


def small(drawn: object, most: int) -> object:
    """Reduce a drawn number below ``most``, except one in four, which mostly stays far out of range."""
    return drawn % most if type(drawn) is int and drawn >= 0 and drawn % 4 else drawn


def on_real_tracks(case: schemathesis.Case, served: ServedLibrary) -> None:
    """Make most commands use existing tracks with their current revisions."""
    run = case.path_parameters["run_id"]
    command = case.body.get("command") if isinstance(case.body, dict) else None
    if run != served.names["run_id"] or not isinstance(command, dict) or "key" not in command:
        return
    tracks = served.get(f"/api/runs/{run}/tracks").json()["id"]
    docs = served.get(f"/api/runs/{run}/annotation").json()["docs"]
    known = {f"m{track}": 0 for track in tracks} | {doc["key"]: doc["revision"] for doc in docs}
    names = sorted(known)
    if command["name"] != "create_track":
        command["key"] = names[len(case.body["op_id"]) % len(names)]
    if "others" in command:
        command["others"] = names[: 1 + len(command["others"])]
    if command.get("box"):
        left, top, right, bottom = (float(edge) % 300 for edge in command["box"])
        command["box"] = [left, top, max(left, right) + 1, max(top, bottom) + 1]
    for name in ("frame", "first", "last"):
        if name in command:
            command[name] = small(command[name], _FRAMES)
    case.headers["If-Match"] = ", ".join(f'"{key}:{revision}"' for key, revision in known.items())


def test_the_document_lists_every_route(served: ServedLibrary) -> None:
    paths = served.get("/api/openapi.json").json()["paths"]
    assert len(paths) > 30
    for path, methods in paths.items():
        for method, operation in methods.items():
            assert "operationId" in operation, (method, path)
            for status, answer in operation["responses"].items():
                if status.startswith(("4", "5")):
                    schema = answer["content"]["application/json"]["schema"]
                    assert schema == {"$ref": "#/components/schemas/ErrorAnswer"}, (method, path, status)


def test_the_data_folder_is_unchanged_afterwards(served: ServedLibrary) -> None:
    """The run is unchanged, and no partial file is left."""
    run = served.get(f"/api/runs/{served.names['run_id']}").json()
    assert run["state"] == "complete"
    assert not list((served.server.server.settings.home / "uploads").glob(".*.part"))
