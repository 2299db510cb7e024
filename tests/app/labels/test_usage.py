"""The number of tracks that people have labelled, on SQLite and PostgreSQL."""

from __future__ import annotations

import pytest

from app.edits.documents import TrackDoc
from app.errors import NotFound
from app.labels.usage import LabelUse, label_usage
from app.storage.database import Database
from app.storage.models import Run, TrackDocument, Video
from tests.app.toy_server import Server

GTSRB = "gtsrb-43"


def add_run(
    database: Database, video: str, run: str, labels: dict[str, int | None], gone: tuple[str, ...] = ()
) -> None:
    with database.write() as session:
        if session.get(Video, video) is None:
            own = "vienna" if video.startswith("c") else None
            session.add(Video(id=video, name="a.mp4", path="/a.mp4", size=1, state="ready", label_set=own))
            session.flush()
        session.add(Run(id=run, video_id=video, state="complete"))
        session.flush()
        for key, label in labels.items():
            document = TrackDoc(key=key, class_id=label, gone=key in gone).model_dump(mode="json")
            session.add(TrackDocument(run_id=run, key=key, revision=1, document=document))


def test_tracks_and_videos_are_counted_by_given_labels(database: Database) -> None:
    add_run(database, "a" * 64, "1" * 32, {"m1": 14, "m2": 14, "m3": -1, "m4": None, "m5": 13, "m6": 14}, gone=("m6",))
    add_run(database, "a" * 64, "2" * 32, {"m1": 14})
    add_run(database, "b" * 64, "3" * 32, {"m1": 14})
    add_run(database, "c" * 64, "4" * 32, {"m1": 14})
    assert label_usage(database, GTSRB) == {14: LabelUse(tracks=4, videos=2), 13: LabelUse(tracks=1, videos=1)}
    assert label_usage(database, "vienna") == {14: LabelUse(tracks=1, videos=1)}
    with pytest.raises(NotFound):
        label_usage(database, "none")


def test_usage_over_http(server: Server) -> None:
    assert server.client.get(f"/api/label-sets/{GTSRB}/usage").json() == {}
    assert server.client.get("/api/label-sets/none/usage").status_code == 404
