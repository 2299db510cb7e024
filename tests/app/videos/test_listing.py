"""The list of videos: each video's runs and review progress, with few queries for thousands of videos."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import pytest
from sqlalchemy import event

from app.events import EventBus
from app.storage.database import Database
from app.storage.migrations.versions.v0013_sums import fill
from app.storage.models import Base, Run, TrackDocument, Video
from app.videos.paths import existing_files
from app.videos.tags import TagRequest, change_tags
from app.videos.view import VideoView, video_listing, video_view


def _run(name: str, video: int, **fields: object) -> Run:
    filled = {"state": "complete", "parameters": {}, "models": {}, "summary": {}, **fields}
    return Run(id=name * 32, video_id=f"{video:064d}", **filled)


def _make_database(url: str, videos: int) -> Database:
    database = Database(url)
    Base.metadata.create_all(database.engine)
    with database.write() as session:
        session.add_all(Video(id=f"{i:064d}", name=f"{i}", path="/gone", size=1, warnings=[]) for i in range(videos))
        session.flush()
        early, late = datetime(2026, 1, 1, tzinfo=UTC), datetime(2026, 2, 1, tzinfo=UTC)
        session.add_all(
            [
                _run("a", 0, created=late, order=1, tracks=3),
                _run("b", 0, created=early, order=2, tracks=5),
                _run("c", 0, created=late, order=3, kind="whatif", parent_id=None, tracks=9),
                _run("d", 0, created=late, order=4, state="running"),
                _run("e", 1, order=5, state="failed"),
            ]
        )
        session.flush()
        documents = {"m1": ("open", False), "m2": ("accepted", False), "m3": ("open", True), "h4": ("rejected", True)}
        documents |= {"m4": ("needs_work", False), "h5": ("rejected", False), "h6": ("open", False)}
        for key, (review, gone) in documents.items():
            document = {"review": review, "gone": gone}
            session.add(TrackDocument(run_id="b" * 32, key=key, revision=1, document=document))
            session.add(TrackDocument(run_id="a" * 32, key=key, revision=1, document=document))
        session.flush()
        fill(session.connection())
    return database


def _list_videos(database: Database) -> tuple[list[VideoView], int]:
    statements: list[str] = []
    event.listen(database.engine, "before_cursor_execute", lambda *args: statements.append(str(args[2])))
    with database.read() as session:
        listed = sorted(video_listing(session), key=lambda one: one["id"])
        views = [VideoView.model_validate(one, strict=True, extra="forbid") for one in listed]
    return views, sum(statement.startswith("SELECT") for statement in statements)


def test_the_newest_complete_run_and_its_verdicts_are_listed(database_url: str) -> None:
    # one of its five tracks is deleted, two of three drawn ones exist; needs-work counts as open
    database = _make_database(database_url, 3)
    views, _ = _list_videos(database)
    assert [(one.runs, one.latest_run) for one in views] == [(4, "b" * 32), (1, "e" * 32), (0, None)]
    assert [(one.review.tracks, one.review.reviewed) for one in views] == [(6, 2), (0, 0), (0, 0)]
    with database.read() as session:
        assert [video_view(session, session.get_one(Video, one.id)) for one in views] == views
    database.close()


@pytest.mark.parametrize("videos", [2, 1100])
def test_the_queries_do_not_grow_with_the_videos(tmp_path: Path, videos: int) -> None:
    database = _make_database(f"sqlite:///{tmp_path / 'tsr.sqlite'}", videos)
    views, queries = _list_videos(database)
    assert len(views) == videos
    assert queries == 3
    database.close()


def test_many_videos_are_tagged_with_few_queries(tmp_path: Path) -> None:
    database, events = _make_database(f"sqlite:///{tmp_path / 'tsr.sqlite'}", 600), EventBus()
    statements: list[str] = []
    event.listen(database.engine, "before_cursor_execute", lambda *args: statements.append(str(args[2])))
    videos = [f"{i:064d}" for i in range(600)]
    assert change_tags(database, events, TagRequest(videos=videos[:1], add=["rain"], remove=[])) == 1
    assert change_tags(database, events, TagRequest(videos=videos, add=["night", "rain"], remove=[])) == 600
    assert change_tags(database, events, TagRequest(videos=videos[:2], add=["rain", "snow"], remove=["snow"])) == 0
    assert change_tags(database, events, TagRequest(videos=videos, add=[], remove=["rain"])) == 600
    assert len(statements) < 50
    with database.read() as session:
        told = events.after(session, 0, 10_000)
        assert len(told) == 1 + 600 + 600
        assert {tuple(each.data["tags"]) for each in told[-600:]} == {("night",)}
        last = video_view(session, session.get_one(Video, told[-1].subject))
        assert told[-1].data == last.model_dump(mode="json")
    database.close()


def test_files_are_found_singly_and_in_a_large_folder(tmp_path: Path) -> None:
    few, many = tmp_path / "few", tmp_path / "many"
    few.mkdir()
    many.mkdir()
    (few / "a.mp4").touch()
    for number in range(0, 40, 2):
        (many / f"{number}.mp4").touch()
    (many / "1.mp4").symlink_to(many / "0.mp4")
    (many / "3.mp4").symlink_to(many / "gone")
    (many / "5.mp4").mkdir()
    paths = [few / "a.mp4", few / "b.mp4", Path("/gone/c.mp4"), *(many / f"{number}.mp4" for number in range(40))]
    found = existing_files([str(path) for path in paths])
    assert found == {str(path) for path in paths if path.is_file()}
    assert len(found) == 22
