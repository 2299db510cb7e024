"""A served toy home, with helpers for tests of exports and imports."""

from __future__ import annotations

import io
import json
import shutil
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.edits.documents import TrackDoc
from app.edits.log_store import documents_of
from app.exchange.dataset import dataset_of
from app.exchange.import_file import ImportFile
from app.exchange.run_sources import run_source
from tests.app.inline_worker import run_jobs
from tests.app.toy_home import ToyHome
from tests.app.toy_server import Server
from tsr_engine.exchange.dataset import Dataset, Track
from tsr_engine.exchange.filters import clip_track

ALL_STATES = ["open", "accepted", "needs_work", "rejected"]
MAX_ERROR_PX = 0.02
"""Rounding error of two decimals, px."""


@dataclass
class ExchangeClient:
    """The server and its run."""

    server: Server
    video_id: str
    run_id: str

    @property
    def home(self) -> Path:
        return self.server.settings.home

    def post(self, path: str, body: Any = None, **more: Any) -> Any:
        """The JSON answer of a POST request that must succeed."""
        answer = self.server.client.post(path, json=body, **more)
        assert answer.status_code < 300, answer.text
        return answer.json()

    def get(self, path: str) -> Any:
        """The JSON answer of a GET request that must succeed."""
        answer = self.server.client.get(path)
        assert answer.status_code == 200, answer.text
        return answer.json()

    def documents(self) -> dict[str, TrackDoc]:
        """The run's documents."""
        with self.server.context.database.read() as session:
            return documents_of(session, self.run_id)

    def edit(self, command: dict[str, Any], revisions: dict[str, int], author: str = "ada", run: str = "") -> Any:
        """Run one command."""
        body = {"op_id": np.random.default_rng().bytes(12).hex(), "author": author, "command": command}
        tag = ", ".join(f'"{key}:{revision}"' for key, revision in revisions.items())
        return self.post(f"/api/runs/{run or self.run_id}/edits", body, headers={"If-Match": tag} if tag else {})

    def undo(self, author: str = "ada", run: str = "") -> Any:
        """Undo the author's last command; returns what it was."""
        last = self.get(f"/api/runs/{run or self.run_id}/annotation?author={author}")["undo"]
        self.edit({"name": "undo", "op_id": last["op_id"]}, {}, author, run)
        return last

    def export(self, **request: Any) -> Any:
        """Request an export of all tracks and make it in this process; returns the finished output."""
        asked = {"runs": [self.run_id], "format": "cvat-video", "states": ALL_STATES, "not_in_set": "class", **request}
        output = self.post("/api/exports", asked)
        run_jobs(self.server.context, "export")
        return self.get(f"/api/outputs/{output['id']}")

    def download(self, output: Any) -> bytes:
        answer = self.server.client.get(f"/api/outputs/{output['id']}/download")
        assert answer.status_code == 200, answer.text
        return answer.content

    def output_files(self) -> list[Path]:
        """All files and folders below the folder of outputs."""
        folder = self.home / "artefacts"
        return sorted(folder.rglob("*")) if folder.is_dir() else []

    def import_file(self, content: bytes, kind: str, **query: Any) -> Any:
        answer = self.send_import(content, kind, **query)
        assert answer.status_code == 201, answer.text
        return answer.json()

    def send_import(self, content: bytes, kind: str, **query: Any) -> Any:
        """Send an import; returns the response."""
        request = {"as": kind, **query}
        if kind == "annotation":
            request.setdefault("run", self.run_id)
        return self.server.client.post(f"/api/videos/{self.video_id}/imports", params=request, content=content)

    def import_inline(self, content: bytes, kind: Any, name: str, author: str = "ada") -> Any:
        """Import in this process, so that a test can interfere."""
        path = self.home / name
        path.write_bytes(content)
        incoming = ImportFile(path, name, author=author)
        found = self.server.context.imports.import_file(self.video_id, incoming, kind, self.run_id)
        return found.model_dump(mode="json")

    def dataset(self, run_id: str | None = None) -> Dataset:
        """The run as it would be exported now."""
        with self.server.context.database.read() as session:
            return dataset_of([run_source(session, self.server.settings, run_id or self.run_id)])

    def tracks(self, run_id: str | None = None) -> dict[str, Track]:
        """Tracks of the data set by name."""
        return {track.uid: track for track in self.dataset(run_id).videos[0].tracks()}

    def make_corrections(self) -> None:
        """Move a box, relabel, hide, reject, draw a track, write a note."""
        track = self.tracks()["m1"]
        middle = int(track.frames[len(track.frames) // 2])
        box = (track.boxes[len(track.frames) // 2] + [1.5, 2.25, 2.5, 3.75]).tolist()
        self.edit({"name": "set_box", "key": "m1", "frame": middle, "box": box}, {"m1": 0})
        self.edit({"name": "relabel_track", "key": "m1", "frame": middle, "class_id": 13}, {"m1": 1})
        self.edit({"name": "set_occluded", "key": "m1", "frame": middle + 2, "value": True}, {"m1": 2})
        note = {"name": "add_note", "key": "m1", "frame": middle, "note_id": "n1", "text": "bent <sign> & co"}
        self.edit(note, {"m1": 3})
        self.edit({"name": "set_review", "key": "m2", "frame": 1, "review": "rejected"}, {"m2": 0})
        drawn = {"key": "hdrawn01"}
        self.edit({"name": "create_track", **drawn, "frame": 5, "box": [20, 30, 44, 52], "class_id": 1}, {})
        self.edit({"name": "set_box", **drawn, "frame": 11, "box": [26.5, 33.25, 50, 58]}, {"hdrawn01": 1})
        self.edit({"name": "set_box", **drawn, "frame": 15, "box": [30, 36, 56, 62]}, {"hdrawn01": 2})
        self.edit({"name": "set_outside", **drawn, "frame": 12, "value": True}, {"hdrawn01": 3})


def open_client(made: ToyHome, folder: Path) -> ExchangeClient:
    """A server on a copy of a home."""
    shutil.copytree(made.settings.home, folder / "home")
    return ExchangeClient(Server(folder / "home", roots=(made.video.parent,)), made.video_id, made.run_id)


def unzipped(content: bytes) -> dict[str, bytes]:
    """Contents of an archive's files."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def zipped(files: dict[str, bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return out.getvalue()


def manifest_of(content: bytes) -> Any:
    return json.loads(unzipped(content)["manifest.json"])


def table_of(content: bytes) -> str:
    """The table in an archive."""
    return next(content for name, content in unzipped(content).items() if name.endswith(".csv")).decode()


def clipped_to_picture(track: Track, width: int = 320, height: int = 240) -> Track:
    """The track clipped at the picture, as importers do."""
    part, _ = clip_track(track, (width, height))
    assert part is not None
    return part


def assert_same_track(found: Track, wanted: Track, max_error: float = MAX_ERROR_PX) -> None:
    """Frames, boxes, classes and hidden frames are equal."""
    np.testing.assert_array_equal(found.frames, wanted.frames)
    np.testing.assert_allclose(found.boxes, wanted.boxes, atol=max_error)
    np.testing.assert_array_equal(found.occluded, wanted.occluded)
    for frame in range(len(found.frames)):
        found_label = found.label if found.labels is None else found.labels[frame]
        wanted_label = wanted.label if wanted.labels is None else wanted.labels[frame]
        assert found_label == wanted_label
