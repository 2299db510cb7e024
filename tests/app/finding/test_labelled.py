"""Videos by label, attribute and state of their tracks, as people have left them; on SQLite and PostgreSQL."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from app.edits.documents import KeyFrame, Segment, TrackDoc
from app.errors import Invalid, NotFound
from app.finding.labelled import LabelledVideos, Wanted
from app.labels.store import start
from app.storage.database import Database
from app.storage.models import Base, Run, TrackDocument, Video
from tests.app.databases import cluster, database_url
from tests.app.exchange.conftest import desk, tracked
from tests.app.exchange.exchange_desk import Desk
from tests.app.labels.test_service import own_set
from tsr_engine.labels.files import shipped_set
from tsr_engine.labels.model import Attribute, Label, LabelSet

__all__ = ["cluster", "database_url", "desk", "tracked"]

BOX = (0.0, 0.0, 9.0, 9.0)
STOP, YIELD, MINE = 14, 13, 43
CHOICES = (Attribute(name="dirty", kind="checkbox", default=False), Attribute(name="lit é", kind="text", mutable=True))


@dataclass
class World:
    """Videos with one run each, and what an engine calls their tracks."""

    database: Database
    engine: dict[str, list[tuple[int, int]]] = field(default_factory=dict)
    asked: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.labelled = LabelledVideos(self.database, self)  # type: ignore[arg-type]

    def track_classes(self, run_id: str) -> list[tuple[int, int]]:
        """As ``EvidenceService`` has it."""
        self.asked.append(run_id)
        if run_id not in self.engine:
            raise NotFound("There is no evidence.")
        return self.engine[run_id]

    def add(self, name: str, classes: list[int] | None, *docs: TrackDoc, **more: Any) -> None:
        """A video whose run has tracks m1, m2 ... of these classes."""
        own = {key: more.pop(key) for key in ("label_set",) if key in more}
        with self.database.write() as session:
            if session.get(Video, name * 64) is None:
                session.add(Video(id=name * 64, name=name, path="/gone", size=1, warnings=[], **own))
                session.flush()
            run = more.pop("run", name) * 32
            session.add(Run(id=run, video_id=name * 64, **{"state": "complete", **more}))
            session.flush()
            for doc in docs:
                stored = doc.model_dump(mode="json")
                session.add(TrackDocument(run_id=run, key=doc.key, revision=1, document=stored))
        if classes is not None:
            self.engine[run] = [(track, number) for track, number in enumerate(classes, start=1)]

    def find(self, **wanted: Any) -> dict[str, int]:
        """Names of the videos and how many tracks."""
        return {video[0]: tracks for video, tracks in self.labelled.find(Wanted(**wanted)).videos.items()}


@pytest.fixture
def world(database_url: str) -> Iterator[World]:
    """An empty library whose set has a label of its own."""
    database = Database(database_url)
    Base.metadata.create_all(database.engine)
    gtsrb = shipped_set("gtsrb-43")
    stop = gtsrb.labels[STOP].model_copy(update={"attributes": CHOICES})
    own = Label(id=MINE, key="bus-stop", name="bus stop", attributes=CHOICES[1:])
    halt = Label(id=44, key="halt-here", name="halt here", merged_into=STOP)
    content = (*gtsrb.labels[:STOP], stop, *gtsrb.labels[STOP + 1 :], own, halt)
    with database.write() as session:
        start(session, LabelSet(key="gtsrb-43", name="Ours", next_id=45, labels=content), "ann", "Made.")
    yield World(database)
    database.close()


def test_what_people_say_goes_before_what_the_engine_says(world: World) -> None:
    world.add("a", [STOP, STOP, YIELD, -1])
    world.add("b", [STOP, YIELD], TrackDoc(key="m1", class_id=MINE), TrackDoc(key="m2", class_id=44))
    world.add("c", [STOP], TrackDoc(key="m1", gone=True), TrackDoc(key="hdrawn01", class_id=MINE))
    world.add("d", [YIELD], TrackDoc(key="hsplit01", segments=[Segment(track=1, first=5, last=9)]))
    assert world.find(label="stop") == {"a": 2, "b": 1}
    assert world.find(label="halt here") == {"a": 2, "b": 1}, "a merged label is the one that stands for it"
    assert world.find(label="bus stop") == {"b": 1, "c": 1}
    assert world.find(label="yield") == {"a": 1, "d": 2}
    assert world.find(label="-1") == {"a": 1}
    assert world.find() == {"a": 4, "b": 2, "c": 1, "d": 2}
    with pytest.raises(Invalid, match="No label set in use has a label called 'boar'"):
        world.find(label="boar")


def test_a_track_has_all_that_is_asked_for_at_once(world: World) -> None:
    world.add("a", [STOP, STOP, YIELD], TrackDoc(key="m1", review="accepted"), TrackDoc(key="m3", review="needs_work"))
    world.add("b", [STOP, STOP], TrackDoc(key="m1", ignore=True), TrackDoc(key="m2", not_a_sign=True))
    assert world.find(label="stop", state="accepted") == {"a": 1}
    assert world.find(label="stop", state="open") == {"a": 1}
    assert world.find(state="needs_work") == {"a": 1}
    assert (world.find(state="ignored"), world.find(state="rejected")) == ({"b": 1}, {"b": 1})
    assert world.find(label="yield", state="accepted") == {}


def test_answers_to_attributes(world: World) -> None:
    lit = {"3": KeyFrame(box=BOX), "7": KeyFrame(attributes={"lit é": "dusk%_"})}
    world.add("a", [STOP, STOP, YIELD], TrackDoc(key="m1", attributes={"dirty": True}))
    world.add("b", [STOP], TrackDoc(key="m1", keys=lit, attributes={"metres": 40.0}))
    world.add("c", [YIELD], TrackDoc(key="m1", class_id=MINE, attributes={"lit é": "day"}))
    assert world.find(attribute="dirty", value="true") == {"a": 1}
    assert world.find(attribute="dirty", value="false") == {"a": 1, "b": 1}, "nobody has said so, the label does"
    assert world.find(attribute="dirty") == {"a": 1}
    assert world.find(attribute="lit é", value="dusk%_") == {"b": 1}
    assert world.find(attribute="lit é") == {"b": 1, "c": 1}
    assert world.find(attribute="lit é", label="bus stop") == {"c": 1}
    assert world.find(attribute="metres", value="40") == {"b": 1}
    assert world.find(attribute="lit _") == {}


def test_a_video_stands_with_the_run_that_it_is_opened_with_and_goes_by_its_own_set(world: World) -> None:
    world.add("a", [STOP], run="1", order=1)
    world.add("a", [YIELD], run="2", order=2)
    world.add("a", [STOP], run="3", order=3, kind="imported", labels={"set": "gtsrb-43"})
    world.add("b", [STOP], state="running")
    own_set(world.database, "team", Label(id=0, key="stop", name="halt"), Label(id=14, key="other", name="other"))
    world.add("c", [STOP, 0], label_set="team", labels={"set": "team"})
    world.add("d", [0, 1], labels={"keys": ["stop", "whatever"]})
    assert world.find(label="stop") == {"c": 1, "d": 1}
    assert world.find(label="yield") == {"a": 1}
    assert world.find(label="other") == {"c": 1}
    assert world.find(label="-1") == {"d": 1}


def test_evidence_is_read_once_as_far_as_the_time_goes(world: World) -> None:
    for name in "abcd":
        world.add(name, [STOP])
    world.add("e", None)
    found = world.labelled.find(Wanted(label="stop"), budget=-1)
    assert (found.videos, found.left, found.unreadable) == ({}, 5, 0)
    found = world.labelled.find(Wanted(label="stop"))
    assert (len(found.videos), found.left, found.unreadable) == (4, 0, 1)
    world.asked.clear()
    assert world.find(label="stop") == dict.fromkeys("abcd", 1)
    assert World(world.database, world.engine).find(label="stop") == dict.fromkeys("abcd", 1), "another process"
    assert world.asked == []


def test_thousands_of_videos(tmp_path: Path) -> None:
    database = Database(f"sqlite:///{tmp_path / 'tsr.sqlite'}")
    Base.metadata.create_all(database.engine)
    world = World(database)
    videos = 5000
    document = TrackDoc(key="m1", class_id=STOP, review="accepted", keys={"1": KeyFrame(box=BOX)}).model_dump(
        mode="json"
    )
    with database.write() as session:
        for i in range(videos):
            session.add(Video(id=f"{i:064d}", name=f"{i}", path="/gone", size=1, warnings=[]))
        session.flush()
        session.add_all(Run(id=f"{i:032d}", video_id=f"{i:064d}", state="complete", order=i) for i in range(videos))
        session.flush()
        for i in range(videos):
            session.add(TrackDocument(run_id=f"{i:032d}", key="m1", revision=1, document=document))
    world.engine = {f"{i:032d}": [(track, YIELD) for track in range(1, 31)] for i in range(videos)}
    while world.labelled.find(Wanted(label="stop")).left:
        pass
    began = time.process_time()
    assert len(world.labelled.find(Wanted(label="stop", state="accepted")).videos) == videos
    assert len(world.labelled.find(Wanted(label="yield")).videos) == videos
    took = (time.process_time() - began) / 2
    print(f"{took:.2f} s a question")
    assert took < 3
    database.close()


def test_it_is_told_over_http(desk: Desk, find: Callable[..., Any]) -> None:
    tracks = list(desk.tracks().values())
    stops = sum(track.label == STOP for track in tracks)
    assert find(label="stop") == ({desk.video_id: stops} if stops else {})
    assert find() == {desk.video_id: len(tracks)}
    answer = desk.server.client.get("/api/videos/matching?value=yes")
    assert answer.json()["error"]["field"] == "attribute"
    assert "boar" in json.dumps(desk.server.client.get("/api/videos/matching?label=boar").json())


@pytest.fixture
def find(desk: Desk) -> Callable[..., Any]:
    """Ask the server of the desk."""

    def ask(**wanted: str) -> Any:
        answer = desk.server.client.get("/api/videos/matching", params=wanted)
        assert answer.status_code == 200, answer.text
        assert answer.json()["left"] == 0
        return answer.json()["videos"]

    return ask
