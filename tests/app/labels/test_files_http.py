"""Label files over HTTP: exported in every format and imported again; hostile and damaged files are refused."""

from __future__ import annotations

import json
from typing import Any

import pytest
from starlette.testclient import TestClient

from tests.app.toy_server import Server
from tsr_engine.exchange.label_files.formats import LABEL_FORMATS
from tsr_engine.labels.files import parse_set

GTSRB = "gtsrb-43"
_RAW = {"Content-Type": "application/octet-stream"}
CVAT = [
    {"name": "yield", "attributes": []},
    {
        "name": "pedestrian_crossing",
        "color": "#00ff00",
        "attributes": [{"name": "bent", "input_type": "checkbox", "mutable": True, "values": ["false"]}],
    },
    {"name": "bad\u202ename", "attributes": []},
]


def import_labels(client: TestClient, content: bytes | str | list[Any], key: str = GTSRB, **query: Any) -> Any:
    body = json.dumps(content) if isinstance(content, list) else content
    return client.post(f"/api/label-sets/{key}/files", params=query, content=body, headers=_RAW)


def test_missing_labels_of_a_file_are_added_and_known_ones_listed(server: Server) -> None:
    answer = import_labels(server.client, CVAT, name="task.json")
    assert answer.status_code == 200, answer.text
    done = answer.json()
    assert (done["version"], done["sentence"], done["created"]) == (2, "Added 1 label of 'task.json'.", False)
    assert [(label["id"], label["name"], label["colour"]) for label in done["added"]] == [
        (43, "pedestrian_crossing", "#00ff00")
    ]
    assert done["added"][0]["attributes"][0]["mutable"] is True
    assert done["known"] == [{"name": "yield", "id": 13, "key": "give-way"}]
    (refused,) = done["refused"]
    assert refused["reason"] == "task.json, label 3: name: it holds the control character U+202E."
    again = import_labels(server.client, CVAT, name="task.json").json()
    assert (again["version"], again["added"], len(again["known"])) == (2, [], 2)
    assert server.client.get(f"/api/label-sets/{GTSRB}/history").json()[0]["author"] == "ada"


@pytest.mark.parametrize("format", list(LABEL_FORMATS))
def test_every_format_is_exported_and_imported(server: Server, format: str) -> None:
    import_labels(server.client, CVAT)
    answer = server.client.get(f"/api/label-sets/{GTSRB}/file", params={"format": format})
    assert answer.status_code == 200
    assert answer.headers["content-disposition"] == (f'attachment; filename="{GTSRB}-{LABEL_FORMATS[format].file}"')
    done = import_labels(server.client, answer.content, name=LABEL_FORMATS[format].file).json()
    assert done["added"] == []
    assert len(done["known"]) == 44
    made = import_labels(
        server.client, answer.content, key="copy", create=True, name="a.yaml" if format == "yaml" else "a"
    )
    assert made.json()["created"] is True
    copy = parse_set(server.client.get("/api/label-sets/copy").content, "copy")
    assert [label.name for label in copy] == [label["name"] for label in server.client.get("/api/labels").json()]
    assert (copy.key, copy.version) == ("copy", 1)


def test_a_set_of_the_team_is_made_from_a_file_and_used(server: Server) -> None:
    assert import_labels(server.client, "stop\nno parking\n", key="team").status_code == 404
    made = import_labels(server.client, "stop\nno parking\n", key="team", create=True, name="obj.names").json()
    assert (made["version"], made["sentence"]) == (1, "Made the set 'obj.names' (key team) with 2 labels.")
    assert [label["id"] for label in made["added"]] == [0, 1]
    again = import_labels(server.client, "stop\nno stopping\n", key="team", create=True).json()
    assert (again["created"], [label["id"] for label in again["added"]]) == (False, [2])
    assert server.client.put("/api/label-sets/default", json={"set": "team"}).status_code == 200
    assert [label["name"] for label in server.client.get("/api/labels").json()] == ["stop", "no parking", "no stopping"]
    rows = server.client.get("/api/label-sets/team/history").json()
    assert rows[-1]["sentence"] == "Made from obj.names."
    assert server.client.get("/api/label-sets").json()[-1]["key"] == "team"


def test_missing_pictures_of_a_file_are_reported(server: Server) -> None:
    labels = [
        {"id": 0, "key": "a", "name": "a", "pictogram": "sha256:" + "0" * 64},
        {"id": 1, "key": "b", "name": "b", "pictogram": "gtsrb/14"},
    ]
    file = json.dumps({"schema": 1, "key": "x", "name": "X", "next_id": 2, "labels": labels})
    done = import_labels(server.client, file).json()
    assert done["reported"] == [
        "The picture of 'a' was left out: the file does not contain it, and the library lacks it."
    ]
    assert [label["picture"] is None for label in done["added"]] == [True, False]


@pytest.mark.parametrize(
    ("content", "status", "reported"),
    [
        ("", 422, "required"),
        ("\n", 422, "labels: is empty."),
        ("{", 422, "not JSON"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><View>&b;</View>', 400, "DOCTYPE"),
        ('{"schema": 9, "labels": []}', 422, "Update tsr"),
        (b"\xff\xfe", 422, "UTF"),
        ([{"name": "\u202e"}], 422, "No label of the file can be used"),
    ],
)
def test_a_broken_file_changes_nothing(server: Server, content: Any, status: int, reported: str) -> None:
    answer = import_labels(server.client, content)
    assert answer.status_code == status, answer.text
    assert reported in answer.json()["error"]["message"]
    assert server.client.get("/api/label-sets").json()[0]["version"] == 1


def test_a_name_cannot_leave_its_folder(server: Server) -> None:
    assert import_labels(server.client, "stop\n", name="../../x").status_code == 422
    assert import_labels(server.client, "stop\n", name="..").json()["known"][0]["id"] == 14
