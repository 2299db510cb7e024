"""Label sets over HTTP: the routes, their failures, and the stream of events."""

from __future__ import annotations

import base64
import io
from typing import Any

from PIL import Image
from starlette.testclient import TestClient

from tests.app.toy_server import Server
from tsr_engine.labels.files import parse_set, shipped_set

GTSRB = "gtsrb-43"


def changed_set(client: TestClient, **change: Any) -> Any:
    answer = client.post(f"/api/label-sets/{GTSRB}/changes", json={"author": "ada", "change": change})
    assert answer.status_code == 200, answer.text
    return answer.json()


def error_of(client: TestClient, status: int, **change: Any) -> Any:
    answer = client.post(f"/api/label-sets/{GTSRB}/changes", json={"author": "ada", "change": change})
    assert answer.status_code == status, answer.text
    return answer.json()["error"]


def picture() -> str:
    file = io.BytesIO()
    Image.new("RGB", (30, 30), "blue").save(file, "PNG")
    return base64.b64encode(file.getvalue()).decode()


def test_labels_are_listed_with_their_pictures(server: Server) -> None:
    found = server.client.get("/api/labels").json()
    assert [label["id"] for label in found] == list(range(43))
    stop = found[14]
    assert (stop["key"], stop["name"], stop["shape"], stop["teach"]) == ("stop", "stop", "octagon", "sign")
    answer = server.client.get(stop["picture"])
    assert answer.headers["content-type"] == "image/png"
    assert answer.content == server.client.get("/api/labels/14.png").content
    tag = answer.headers["etag"]
    assert server.client.get(stop["picture"], headers={"If-None-Match": tag}).status_code == 304
    assert len(server.client.get("/api/labels/14.png?size=9").content) < len(answer.content)
    assert server.client.get("/api/labels/43.png").status_code == 404
    assert server.client.get("/api/labels/14.png?set=none").status_code == 404
    assert server.client.get(f"/api/labels?video={'0' * 64}").status_code == 404


def test_an_added_label_is_shown_and_sent_to_pages(server: Server) -> None:
    done = changed_set(server.client, type="add", name="no parking", aliases=["Parkverbot"], teach="ignore", pinned=3)
    assert done["version"] == 2
    assert done["sentence"] == "Added 'no parking'."
    assert done["label"] | {"id": 43, "key": "no-parking", "picture": None, "pinned": 3} == done["label"]
    assert server.client.get("/api/labels").json()[43] == done["label"]
    assert (
        server.client.get("/api/labels/43.png").json()["error"]["message"] == "The label 'no parking' has no picture."
    )
    with server.context.database.read() as session:
        (event,) = [event for event in server.context.events.after(session, 0) if event.kind == "labels"]
    assert (event.subject, event.data) == (GTSRB, {"version": 2})


def test_a_picture_is_served_under_its_own_url(server: Server) -> None:
    before = server.client.get("/api/labels").json()[14]["picture"]
    done = changed_set(server.client, type="picture", id=14, png=picture())
    assert done["label"]["picture"] != before
    first, second = (server.client.get(address) for address in (before, done["label"]["picture"]))
    assert first.content == second.content  # the present one, at both URLs
    assert first.headers["etag"] == second.headers["etag"]
    assert changed_set(server.client, type="picture", id=14, png=None)["label"]["picture"] is None
    assert error_of(server.client, 422, type="picture", id=14, png="AAAA")["field"] == "png"


def test_the_set_itself_is_our_file(server: Server) -> None:
    changed_set(server.client, type="add", name="no parking")
    answer = server.client.get(f"/api/label-sets/{GTSRB}")
    assert answer.headers["content-type"] == "application/json"
    assert parse_set(answer.content, "it").get(43).name == "no parking"  # type: ignore[union-attr]
    assert parse_set(server.client.get(f"/api/label-sets/{GTSRB}?version=1").content, "it") == shipped_set(GTSRB)
    assert server.client.get(f"/api/label-sets/{GTSRB}?version=3").status_code == 404
    assert server.client.get("/api/label-sets/none").status_code == 404
    sets = server.client.get("/api/label-sets").json()
    assert sets[0] | {"key": GTSRB, "version": 2, "labels": 44, "default": True, "shipped": True} == sets[0]


def test_failures_name_field_label_and_person(server: Server) -> None:
    changed_set(server.client, type="add", name="no parking")
    error = error_of(server.client, 409, type="add", name="NO PARKING")
    assert (error["code"], error["field"]) == ("taken", "name")
    assert error["details"]["label"]["id"] == 43
    assert error["details"]["by"]["author"] == "ada"
    assert error_of(server.client, 404, type="hide", id=99)["message"] == (
        "The set 'GTSRB, the 43 signs of the German benchmark' has no label 99."
    )
    assert error_of(server.client, 422, type="merge", id=1, into=1)["field"] == "into"
    assert error_of(server.client, 422, type="nonsense")["code"] == "invalid"
    assert error_of(server.client, 422, type="update", id=1, name=None)["field"] == "name"
    assert error_of(server.client, 422, type="add", name="x", pictogram="gtsrb/99")["field"] == "pictogram"
    assert error_of(server.client, 404, type="adopt", set="none")["field"] == "set"
    answer = server.client.post("/api/label-sets/none/changes", json={"change": {"type": "hide", "id": 1}})
    assert answer.status_code == 404
    assert server.client.get(f"/api/label-sets/{GTSRB}/history").json()[0]["version"] == 2


def test_the_history_names_the_servers_author_by_default(server: Server) -> None:
    body = {"change": {"type": "merge", "id": 14, "into": 13}}
    assert server.client.post(f"/api/label-sets/{GTSRB}/changes", json=body).status_code == 200
    changed_set(server.client, type="undo", version=2)
    rows = server.client.get(f"/api/label-sets/{GTSRB}/history").json()
    assert [(row["author"], row["undoes"]) for row in rows] == [("ada", 2), ("ada", None), ("", None)]


def test_the_default_and_a_videos_set_are_chosen(server: Server) -> None:
    answer = server.client.put("/api/label-sets/default", json={"set": GTSRB})
    assert answer.json()["default"] is True
    assert server.client.put("/api/label-sets/default", json={"set": "none"}).status_code == 404
    assert server.client.put(f"/api/videos/{'0' * 64}/label-set", json={"set": None}).status_code == 404
