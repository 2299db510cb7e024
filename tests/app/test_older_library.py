"""A library of version 0.1.0 opens with its edits and ground truth, and its labels keep their meaning.

``tests/golden/libraries/0.1.0.sql`` is the dump of a database written by 0.1.0: one video with one run, five edits of a
person and a ground truth.
"""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

from app.storage.database import Database
from app.storage.models import Run, Video
from tests.app.toy_server import Server

_DUMP = Path(__file__).parents[1] / "golden" / "libraries" / "0.1.0.sql"
VIDEO, RUN = "f" * 64, "a" * 32


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """A data folder as left by 0.1.0."""
    folder = tmp_path / "home"
    folder.mkdir()
    with sqlite3.connect(folder / "tsr.sqlite") as connection:
        connection.executescript(_DUMP.read_text(encoding="utf-8"))
    connection.close()
    return folder


def test_it_opens_with_the_43_labels_and_its_edits(home: Path) -> None:
    server = Server(home)
    with server.client as client:
        docs = {doc["key"]: doc for doc in client.get(f"/api/runs/{RUN}/annotation").json()["docs"]}
        assert {key: doc["class_id"] for key, doc in docs.items()} == {"m1": 13, "m2": -1, "m3": None, "habcdef": 0}
        assert docs["m1"]["keys"]["5"]["class_id"] == 42
        assert len(client.get(f"/api/runs/{RUN}/edits?after=0").json()["edits"]) == 5
        labels = client.get(f"/api/labels?video={VIDEO}").json()
        assert [label["id"] for label in labels] == list(range(43))
        assert labels[13]["name"] == "give way"
        assert client.get("/api/label-sets").json()[0]["key"] == "gtsrb-43"
        assert client.get(f"/api/videos/{VIDEO}").json()["label_set"] is None
        (truth,) = client.get(f"/api/videos/{VIDEO}/ground-truths").json()["ground_truths"]
        boxes = client.get(f"/api/ground-truths/{truth['id']}/boxes?first=0&last=0").json()["boxes"]
        assert [box["class_id"] for box in boxes] == [14]
        change = {"change": {"type": "add", "name": "no parking"}}
        assert client.post("/api/label-sets/gtsrb-43/changes", json=change).json()["label"]["id"] == 43
    assert list((home / "backups").glob("*.sqlite"))


def test_its_rows_have_no_label_set(home: Path) -> None:
    database = Database(f"sqlite:///{home / 'tsr.sqlite'}")
    database.migrate()
    with database.read() as session:
        video, run = session.get(Video, VIDEO), session.get(Run, RUN)
        assert video is not None
        assert run is not None
        assert (video.label_set, run.labels) == (None, None)
    database.close()
