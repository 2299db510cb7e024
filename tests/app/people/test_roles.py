"""Every route has a minimum role and enforces it: every route is called with every role."""

from __future__ import annotations

import re
from typing import Any

import pytest
from fastapi import FastAPI
from starlette.routing import Route
from starlette.testclient import TestClient

from app.api.access import EVERYBODY, authorise, operation_of
from app.api.roles import MIN_ROLES
from app.people.roles import ROLES, at_least
from tests.app.people.team import NAMES, Team
from tests.app.toy_server import Server

_VALUES = {
    "run_id": "0" * 32,
    "video_id": "0" * 64,
    "output_id": "0" * 32,
    "truth_id": "0" * 32,
    "follow_id": "0" * 32,
    "view": "0" * 8,
    "key": "gtsrb-43",
    "name": "x",
}
_ENDLESS = {"follow_events"}


def _routes(app: FastAPI) -> list[Any]:
    """All routes that FastAPI serves, with those of included routers."""

    def walk(routes: Any) -> Any:
        for route in routes:
            inner = getattr(getattr(route, "original_router", None) or getattr(route, "router", None), "routes", None)
            if inner is not None:
                yield from walk(inner)
            elif hasattr(route, "dependant"):
                yield route

    return list(walk(app.routes))


def _operations(server: Server) -> list[tuple[str, str, str]]:
    """Method, path and operation of the OpenAPI document."""
    document = server.client.get("/api/openapi.json").json()
    return [
        (method.upper(), path, found["operationId"])
        for path, methods in document["paths"].items()
        for method, found in methods.items()
    ]


def test_every_route_of_the_document_has_a_role(server_without_people: Server) -> None:
    operations = {operation for _, _, operation in _operations(server_without_people)}
    missing = operations - MIN_ROLES.keys() - EVERYBODY
    assert not missing, f"give these operations a least role in app/api/roles.py: {sorted(missing)}"
    assert "sign_in" in operations


def test_undocumented_routes_have_a_role_and_no_row_is_unused(server_without_people: Server) -> None:
    served = {operation_of(route) for route in _routes(server_without_people.app)}
    assert len(served) > 70
    assert served - MIN_ROLES.keys() - EVERYBODY == set()
    assert MIN_ROLES.keys() - served == set()
    plain = [route.path for route in server_without_people.app.routes if type(route) is Route]
    assert plain == ["/api/openapi.json"], "routes without dependencies hold no role"


def test_every_route_checks_the_role_once_and_first(server_without_people: Server) -> None:
    for route in _routes(server_without_people.app):
        checks = [dependency.call for dependency in route.dependant.dependencies]
        assert checks.index(authorise) == 0, route.path
        assert checks.count(authorise) == 1, route.path


def test_a_role_includes_the_lower_ones() -> None:
    assert ROLES == ("viewer", "annotator", "reviewer", "admin")
    for number, role in enumerate(ROLES):
        assert [at_least(role, least) for least in ROLES] == [n <= number for n in range(4)]


@pytest.mark.parametrize("role", ROLES)
def test_every_route_with_every_role(team_server: Server, team: Team, role: str) -> None:
    client = team.client(NAMES[role])  # type: ignore[index]
    wrong = []
    operations = _operations(team_server)
    assert len(operations) > 60
    for method, path, operation in operations:
        allowed = operation in EVERYBODY or at_least(role, MIN_ROLES[operation])  # type: ignore[arg-type]
        if allowed and operation in _ENDLESS:
            continue
        own = {"name": NAMES[role]} if operation == "get_activity" else {}  # type: ignore[index]
        answer = _call(client, method, path, **own)
        refused = answer.status_code == 403 and answer.json()["error"]["code"] == "role"
        if refused is allowed or answer.status_code >= 500 or (answer.status_code == 401 and operation != "sign_in"):
            wrong.append((operation, answer.status_code, answer.text[:100]))
    assert not wrong


def test_a_refusal_names_the_required_role(team: Team) -> None:
    answer = team.client("Anna").delete(f"/api/videos/{'0' * 64}")
    assert answer.status_code == 403
    assert answer.json()["error"]["message"] == (
        "Anna is an annotator; this needs the role admin. Ask an administrator."
    )
    assert answer.json()["error"]["details"] == {"role": "annotator", "least": "admin"}


def test_undocumented_routes_refuse_strangers_and_serve_viewers(team_server: Server, team: Team) -> None:
    for path in ("/api/artefacts", f"/api/videos/{'0' * 64}/truths"):  # former name
        assert team_server.stranger().get(path).status_code == 401
        assert team.client("Vera").get(path).status_code in (200, 404)
    assert team.client("Vera").delete(f"/api/truths/{'0' * 32}").status_code == 403  # former name
    assert team.client("Vera").get("/rerun/viewer.html").status_code == 200


def test_a_changed_role_applies_to_the_next_request(team_server: Server, team: Team) -> None:
    browser = team.browser("Vera")
    path = f"/api/videos/{'0' * 64}/runs"
    assert browser.post(path, json={}).status_code == 403
    team_server.context.people.set_role("Vera", "reviewer")
    assert browser.post(path, json={}).status_code == 404
    team_server.context.people.set_role("Vera", "viewer")
    assert browser.post(path, json={}).status_code == 403


def _call(client: TestClient, method: str, path: str, **values: str) -> Any:
    filled = re.sub(r"\{(\w+)\}", lambda match: {**_VALUES, **values}.get(match[1], "0"), path)
    return client.request(method, filled)
