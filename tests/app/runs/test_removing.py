"""A run is removed: what is still made from it, and what becomes of its folders."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))
from import_now import work_off
from toy_server import Server


@pytest.fixture
def server(home: Any, tmp_path: Path) -> Any:
    """A server on a copy of the toy home."""
    folder = tmp_path / "home"
    shutil.copytree(home.settings.home, folder)
    made = Server(folder, roots=(home.video.parent,))
    with made.client:
        yield made


@pytest.mark.parametrize(
    ("path", "order"),
    [
        ("/api/runs/{}/recordings", {"first": 0, "stop": 5}),
        ("/api/runs/{}/bundles", {"first": 0, "stop": 5}),
        ("/api/runs/{}/scenes", {}),
        ("/api/exports", {"format": "mot"}),
    ],
)
def test_what_waits_for_a_run_that_is_removed_says_so(
    server: Server, home: Any, path: str, order: dict[str, Any]
) -> None:
    runs = {"runs": [home.run_id]} if "exports" in path else {}
    asked = server.client.post(path.format(home.run_id), json={**order, **runs})
    assert asked.status_code == 202, asked.text
    assert server.client.delete(f"/api/runs/{home.run_id}").status_code == 204
    work_off(server.context)
    made = server.client.get(f"/api/artefacts/{asked.json()['id']}").json()
    assert (made["state"], made["error"]) == ("failed", "The run has been removed in the meantime.")
