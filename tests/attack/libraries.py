"""Data folders to attack: a toy drive, made in a second, or a sample drive tracked by the engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from sample_videos import SHIPPED
from tests.app.inline_worker import run_jobs
from tests.app.toy_home import make_home
from tests.app.toy_server import Server
from tests.attack.concurrent_editors import TrackedLibrary
from tsr_engine.exchange.registry import FORMATS

__all__ = ["UploadFiles", "sample_library", "toy_library"]


@dataclass(frozen=True)
class UploadFiles:
    """Files that people upload, by name.

    Attributes:
        annotations: exports of the run in every format.
        bundles: bug bundles of the run.
    """

    annotations: Mapping[str, bytes]
    bundles: Mapping[str, bytes]


def toy_library(folder: Path) -> TrackedLibrary:
    """A toy drive with its run, on SQLite."""
    home = make_home(folder)
    home.evidence.close()
    home.database.close()
    return TrackedLibrary(home.settings.home, home.video_id, home.run_id, (("m1", 20), ("m2", 20)))


def sample_library(folder: Path, database_url: str | None = None) -> tuple[TrackedLibrary, UploadFiles]:
    """The longer sample drive, tracked by the engine through the server, and its exports.

    Args:
        folder: empty.
        database_url: PostgreSQL; None: SQLite in the folder.
    """
    drive = SHIPPED[0].video
    server = Server(folder / "home", roots=(drive.parent,), database_url=database_url)
    with server.client as client:
        video = client.post("/api/videos", json={"path": str(drive)}).json()["id"]
        run_jobs(server.context)
        run = client.post(f"/api/videos/{video}/runs", json={}).json()["id"]
        run_jobs(server.context)
        answer = client.get(f"/api/runs/{run}/tracks").json()
        tracks = tuple((f"m{key}", frame) for key, frame in zip(answer["id"], answer["first"], strict=True))
        library = TrackedLibrary(folder / "home", video, run, tracks, database_url)
        states = ["open", "edited", "accepted"]
        request = {
            f"{name}.zip": client.post("/api/exports", json={"runs": [run], "format": name, "states": states}).json()
            for name in FORMATS
        }
        bundle = client.post(f"/api/runs/{run}/bundles", json={"first": 10, "stop": 30}).json()
        run_jobs(server.context)
        content = {
            n: client.get(f"/api/outputs/{one['id']}/download").content for n, one in request.items() if "id" in one
        }
        bundles = {"bundle.zip": client.get(f"/api/outputs/{bundle['id']}/download").content}
    return library, UploadFiles(content, bundles)
