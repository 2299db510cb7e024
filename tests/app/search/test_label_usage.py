"""The number of tracks with each label."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from app.errors import NotFound
from app.search.label_usage import LabelUse, label_usage
from app.storage.database import Database
from app.storage.models import Run, SearchRun, SearchTrack, Video
from tests.app.search.conftest import Library


def usage(library: Library) -> dict[str, Any]:
    return library.server.client.get("/api/label-sets/gtsrb-43/usage").json()


def test_labels_of_the_engine_and_of_people_count_once_a_video(library: Library) -> None:
    ids = Counter(str(track["label"]["id"]) for track in library.search()["tracks"] if track["label"])
    expected = {label: {"tracks": tracks, "videos": 1} for label, tracks in ids.items()}
    assert usage(library) == {"labels": expected, "unread": 0}

    ann, keys = library.page(), library.keys()
    ann.send({"name": "relabel_track", "frame": 5, "key": keys[0], "class_id": 40}, f'"{keys[0]}:0"')
    assert usage(library)["labels"]["40"] == {"tracks": 1, "videos": 1}
    ann.send({"name": "delete_track", "frame": 5, "key": keys[0]}, f'"{keys[0]}:1"')
    assert "40" not in usage(library)["labels"]
    assert library.server.client.get("/api/label-sets/none/usage").status_code == 404


def test_current_runs_of_the_set_without_regions_to_ignore_count(database: Database) -> None:
    for video, run, current, set_key, labels, error in (
        ("a" * 64, "1" * 32, True, "gtsrb-43", [14, 14, 13, -1], None),
        ("a" * 64, "2" * 32, False, "gtsrb-43", [14], None),
        ("b" * 64, "3" * 32, True, "gtsrb-43", [14], None),
        ("c" * 64, "4" * 32, True, "vienna", [14], None),
        ("d" * 64, "5" * 32, True, "gtsrb-43", [], "damaged"),
    ):
        _add(database, video, run, current, set_key, labels, error)
    with database.read() as session:
        found = label_usage(session, "gtsrb-43", unread={"3" * 32, "5" * 32})
        assert found.labels == {14: LabelUse(tracks=3, videos=2), 13: LabelUse(tracks=1, videos=1)}
        assert found.unread == 2
        assert label_usage(session, "vienna", unread=set()).labels == {14: LabelUse(tracks=1, videos=1)}
        with pytest.raises(NotFound):
            label_usage(session, "none", unread=set())


def _add(
    database: Database, video: str, run: str, current: bool, set_key: str, labels: list[int], error: str | None
) -> None:
    with database.write() as session:
        if session.get(Video, video) is None:
            session.add(Video(id=video, name="a.mp4", path="/a.mp4", size=1, state="ready"))
            session.flush()
        session.add(Run(id=run, video_id=video, state="complete"))
        session.flush()
        place = {"run_id": run, "video_id": video, "current": current, "set_key": set_key}
        session.add(SearchRun(**place, basis="", seq=0, error=error))
        for number, (label, state) in enumerate([*((label, "open") for label in labels), (14, "ignored")]):
            numbers = dict.fromkeys(("uncertainty", "engine_uncertainty", "size", "x1", "y1", "x2", "y2"), 0.0)
            frames = dict.fromkeys(("frame", "first", "last", "revision", "edited"), 0)
            row = SearchTrack(**place, key=f"m{number}", label=label, state=state, notes="", **numbers, **frames)
            session.add(row)
