"""What the page lists: edits since an export, and labels that a version lacks."""

from __future__ import annotations

import uuid
from pathlib import Path
from typing import Any

from app.training.view import label_facts
from tests.app import toy_home
from tests.app.toy_server import Server
from tests.app.training.training_client import TrainingClient
from tsr_engine.labels.files import shipped_set
from tsr_engine.labels.model import Label


def test_an_export_lists_edits_made_since(tmp_path: Path) -> None:
    home = toy_home.make_home(tmp_path, 80)
    server = Server(home.settings.home, roots=(home.settings.home,))
    with server.client:
        api = TrainingClient(home, server)
        api.accept()
        made = api.export(states=["accepted"])

        def age() -> dict[str, Any]:
            (found,) = api.client.get("/api/models/sources").json()["exports"]
            return dict(found)

        def revert(name: str) -> None:
            now = api.client.get(f"/api/runs/{home.run_id}/annotation?author=ann").json()
            body = {"name": name, "op_id": now[name]["op_id"]}
            url = f"/api/runs/{home.run_id}/edits"
            answer = api.client.post(url, json={"op_id": uuid.uuid4().hex, "author": "ann", "command": body})
            assert answer.status_code == 200, answer.text

        assert age() == {"id": made, "edits": 0, "undone": 0, "gone": []}
        revert("undo")
        assert age() == {"id": made, "edits": 1, "undone": 1, "gone": []}
        revert("redo")
        assert age() == {"id": made, "edits": 2, "undone": 0, "gone": []}
        assert api.client.delete(f"/api/runs/{home.run_id}").status_code == 204
        assert age() == {"id": made, "edits": 0, "undone": 0, "gone": ["drive.mp4"]}
    home.evidence.close()
    home.database.close()


def test_missing_labels_of_a_version_are_listed() -> None:
    gtsrb = shipped_set("gtsrb-43")
    more = Label(id=43, key="bus-stop", name="bus stop")
    bin_ = Label(id=44, key="bin", name="litter bin", teach="background")
    extended_set = gtsrb.model_copy(update={"labels": (*gtsrb.labels, more, bin_), "next_id": 45})
    assert label_facts(None, gtsrb) == {"labels": 43, "lacks": []}
    assert label_facts(None, extended_set) == {"labels": 43, "lacks": ["bus stop"]}
    facts = label_facts(["stop", "bus stop"], extended_set)
    assert (facts["labels"], len(facts["lacks"])) == (2, 42)
