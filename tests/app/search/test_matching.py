"""Videos by label, attribute and state of their corrected tracks, on SQLite and PostgreSQL."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import insert

from app.edits.documents import KeyFrame, Segment, TrackDoc
from app.errors import Invalid
from app.events import EventBus
from app.evidence.service import EvidenceService, StoredRun
from app.exchange.as_run import write_run
from app.exchange.dataset import VideoInfo
from app.labels.store import start
from app.search.index import SearchIndex
from app.search.matching import LabelledVideos, TrackQuery
from app.search.stale import expected_runs
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Base, Run, SearchRun, SearchTrack, TrackDocument, Video
from tests.app.exchange.conftest import api, tracked_home
from tests.app.exchange.exchange_client import ExchangeClient
from tests.app.labels.test_service import own_set
from tsr_engine.exchange.dataset import Track
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.labels.files import shipped_set
from tsr_engine.labels.model import Attribute, Label, LabelSet

__all__ = ["api", "tracked_home"]

BOX = (0.0, 0.0, 9.0, 9.0)
FRAMES = 10
NONE = np.zeros(FRAMES, np.bool_)
TABLE = FrameTable(Fraction(1, 25), *(np.arange(FRAMES),) * 2, NONE, NONE, FRAMES, complete=True)
STOP, YIELD, MINE = 14, 13, 43
CHOICES = (Attribute(name="dirty", kind="checkbox", default=False), Attribute(name="lit é", kind="text", mutable=True))


class RecordingEvidence(EvidenceService):
    """Evidence that records which runs were read."""

    def __init__(self, settings: Settings, database: Database) -> None:
        super().__init__(settings, database)
        self.asked: list[str] = []
        self.listed: list[str] = []

    def stored_run(self, run_id: str) -> StoredRun:
        """Where a run is stored."""
        self.asked.append(run_id)
        return super().stored_run(run_id)

    def uncertainties(self, run_id: str) -> dict[int, float]:
        self.listed.append(run_id)
        return super().uncertainties(run_id)


class IndexedLibrary:
    """Videos with one run each, and the engine's classes of their tracks."""

    def __init__(self, database: Database, home: Path) -> None:
        self.database, self.home = database, home
        self.events = EventBus()
        self.evidence = RecordingEvidence(Settings(home=home), database)
        self.labelled = LabelledVideos(database, SearchIndex(database, self.evidence))

    def add(self, name: str, classes: list[int] | None, *docs: TrackDoc, **more: Any) -> None:
        """Add a video; its run has tracks m1, m2 ... of these classes."""
        own = {key: more.pop(key) for key in ("label_set",) if key in more}
        with self.database.write() as session:
            if session.get(Video, name * 64) is None:
                session.add(Video(id=name * 64, name=name, path="/gone", size=1, warnings=[], frames=FRAMES, **own))
                session.flush()
            run = more.pop("run", name) * 32
            session.add(Run(id=run, video_id=name * 64, folder=run, **{"state": "complete", **more}))
            session.flush()
            self.events.publish(session, "run", run, {"state": "complete"})
            for doc in map(_document_with_boxes, docs):
                stored = doc.model_dump(mode="json")
                session.add(TrackDocument(run_id=run, key=doc.key, revision=1, document=stored))
        if classes is not None:
            facts = VideoInfo(name, name * 64, 64, 48, FRAMES, Fraction(25), None, True, None)
            tracks = [_track(number, label) for number, label in enumerate(classes, start=1)]
            write_run(self.home / run, facts, 1, TABLE, tracks, {})

    def find(self, **wanted: Any) -> dict[str, int]:
        """Names of the videos found and their numbers of tracks."""
        return {video[0]: tracks for video, tracks in self.labelled.find(TrackQuery(**wanted)).videos.items()}


def _track(number: int, label: int) -> Track:
    """A track of the engine in all frames."""
    return Track(str(number), label, np.arange(FRAMES), np.tile(BOX, (FRAMES, 1)), NONE, NONE, np.full(FRAMES, 0.9))


def _document_with_boxes(doc: TrackDoc) -> TrackDoc:
    """A document with boxes: of its engine's track, or drawn."""
    if doc.key.startswith("m"):
        return doc.model_copy(update={"segments": (Segment(track=int(doc.key[1:]), first=0, last=FRAMES - 1),)})
    return doc if doc.segments else doc.model_copy(update={"keys": {"0": KeyFrame(box=BOX)}})


@pytest.fixture
def library(database_url: str, tmp_path: Path) -> Iterator[IndexedLibrary]:
    """An empty library whose set has one additional label."""
    database = Database(database_url)
    Base.metadata.create_all(database.engine)
    gtsrb = shipped_set("gtsrb-43")
    stop = gtsrb.labels[STOP].model_copy(update={"attributes": CHOICES})
    own = Label(id=MINE, key="bus-stop", name="bus stop", attributes=CHOICES[1:])
    halt = Label(id=44, key="halt-here", name="halt here", merged_into=STOP)
    content = (*gtsrb.labels[:STOP], stop, *gtsrb.labels[STOP + 1 :], own, halt)
    with database.write() as session:
        start(session, LabelSet(key="gtsrb-43", name="Ours", next_id=45, labels=content), "ann", "Made.")
    made = IndexedLibrary(database, tmp_path / "home")
    yield made
    made.evidence.close()
    database.close()


def test_corrections_win_over_the_engine(library: IndexedLibrary) -> None:
    library.add("a", [STOP, STOP, YIELD, -1])
    library.add("b", [STOP, YIELD], TrackDoc(key="m1", class_id=MINE), TrackDoc(key="m2", class_id=44))
    library.add("c", [STOP], TrackDoc(key="m1", gone=True), TrackDoc(key="hdrawn01", class_id=MINE))
    library.add("d", [YIELD], TrackDoc(key="hsplit01", segments=[Segment(track=1, first=5, last=9)]))
    assert library.find(label="stop") == {"a": 2, "b": 1}
    assert library.find(label="halt here") == {"a": 2, "b": 1}, "a merged label is the one that stands for it"
    assert library.find(label="bus stop") == {"b": 1, "c": 1}
    assert library.find(label="yield") == {"a": 1, "d": 2}
    assert library.find(label="-1") == {"a": 1}
    assert library.find() == {"a": 4, "b": 2, "c": 1, "d": 2}
    with pytest.raises(Invalid, match="^No label of the label sets? .* has the key, name, alias or number 'boar'"):
        library.find(label="boar")
    with pytest.raises(Invalid, match="'bus'. Is it 'bus stop'"):
        library.find(label="bus")  # only a whole name


def test_one_track_must_meet_all_filters(library: IndexedLibrary) -> None:
    library.add(
        "a", [STOP, STOP, YIELD], TrackDoc(key="m1", review="accepted"), TrackDoc(key="m3", review="needs_work")
    )
    library.add("b", [STOP, STOP], TrackDoc(key="m1", ignore=True), TrackDoc(key="m2", not_a_sign=True))
    assert library.find(label="stop", state="accepted") == {"a": 1}
    assert library.find(label="stop", state="open") == {"a": 1}
    assert library.find(state="needs_work") == {"a": 1}
    assert (library.find(state="ignored"), library.find(state="rejected")) == ({"b": 1}, {"b": 1})
    assert library.find(label="yield", state="accepted") == {}


def test_attribute_values_are_found(library: IndexedLibrary) -> None:
    lit = {"3": KeyFrame(box=BOX), "7": KeyFrame(attributes={"lit é": "dusk%_"})}
    library.add("a", [STOP, STOP, YIELD], TrackDoc(key="m1", attributes={"dirty": True}))
    library.add("b", [STOP], TrackDoc(key="m1", keys=lit, attributes={"metres": 40.0}))
    library.add("c", [YIELD], TrackDoc(key="m1", class_id=MINE, attributes={"lit é": "day"}))
    assert library.find(attribute="dirty", value="true") == {"a": 1}
    assert library.find(attribute="dirty", value="false") == {"a": 1, "b": 1}, "nobody has said so, the label does"
    assert library.find(attribute="dirty") == {"a": 1}
    assert library.find(attribute="lit é", value="dusk%_") == {"b": 1}
    assert library.find(attribute="lit é") == {"b": 1, "c": 1}
    assert library.find(attribute="lit é", label="bus stop") == {"c": 1}
    assert library.find(attribute="metres", value="40") == {"b": 1}
    assert library.find(attribute="lit _") == {}


def test_a_video_is_searched_by_its_displayed_run_and_its_own_set(library: IndexedLibrary) -> None:
    library.add("a", [STOP], run="1", order=1)
    library.add("a", [YIELD], run="2", order=2)
    library.add("a", [STOP], run="3", order=3, kind="imported", labels={"set": "gtsrb-43"})
    library.add("b", [STOP], state="running")
    own_set(library.database, "team", Label(id=0, key="stop", name="halt"), Label(id=14, key="other", name="other"))
    library.add("c", [STOP, 0], label_set="team", labels={"set": "team"})
    library.add("d", [0, 1], labels={"keys": ["stop", "whatever"]})
    assert library.find(label="stop") == {"c": 1, "d": 1}
    assert library.find(label="yield") == {"a": 1}
    assert library.find(label="other") == {"c": 1}
    assert library.find(label="-1") == {"d": 1}


def test_evidence_is_read_once_within_the_time_limit(library: IndexedLibrary) -> None:
    for name in "abcd":
        library.add(name, [STOP])
    library.add("e", None)
    found = library.labelled.find(TrackQuery(label="stop"), budget=0)
    assert (found.videos, found.left, found.unreadable) == ({}, 5, 0)
    found = library.labelled.find(TrackQuery(label="stop"), budget=60)
    assert (len(found.videos), found.left, found.unreadable) == (4, 0, 1)
    library.evidence.asked.clear()
    assert library.find(label="stop") == dict.fromkeys("abcd", 1)
    other = IndexedLibrary(library.database, library.home)
    assert other.find(label="stop") == dict.fromkeys("abcd", 1), "another process"
    other.evidence.close()
    assert {*library.evidence.asked, *other.evidence.asked} <= {"e" * 32}, "what could not be read is tried once more"


def test_a_run_without_uncertainties_is_processed_once(library: IndexedLibrary) -> None:
    library.add("a", [STOP] * 20)
    assert library.find(label="stop") == {"a": 20}
    assert library.evidence.listed == ["a" * 32]


def test_a_set_counts_as_used_before_its_run_is_read(library: IndexedLibrary) -> None:
    own_set(library.database, "team", Label(id=0, key="boar", name="wild boar"))
    library.add("a", [0], label_set="team", labels={"set": "team"})
    found = library.labelled.find(TrackQuery(label="wild boar"), budget=0)
    assert (found.videos, found.left) == ({}, 1)
    assert library.find(label="wild boar") == {"a": 1}


def test_thousands_of_videos_are_matched_fast(tmp_path: Path) -> None:
    database = Database(f"sqlite:///{tmp_path / 'tsr.sqlite'}")
    Base.metadata.create_all(database.engine)
    videos = 2000
    row = dict.fromkeys(("uncertainty", "engine_uncertainty", "size", "x1", "y1", "x2", "y2"), 1.0)
    row |= {**dict.fromkeys(("frame", "first", "last", "revision", "edited"), 0), "notes": "", "set_key": "gtsrb-43"}
    row |= {"current": True, "label": YIELD, "state": "open"}
    touched = {"label": STOP, "state": "accepted"}
    with database.write() as session:
        for i in range(videos):
            session.add(Video(id=f"{i:064d}", name=f"{i}", path="/gone", size=1, warnings=[]))
        session.flush()
        session.add_all(Run(id=f"{i:032d}", video_id=f"{i:064d}", order=i, state="complete") for i in range(videos))
        session.flush()
        known = {"set_key": "gtsrb-43", "seq": 0, "current": True}
        for run in expected_runs(session).values():
            session.add(SearchRun(run_id=run.run_id, video_id=run.video_id, basis=run.basis, **known))
        session.flush()
        tracks = [
            row | {"run_id": f"{i:032d}", "video_id": f"{i:064d}", "key": f"m{track}"} | (touched if track == 1 else {})
            for i in range(videos)
            for track in range(1, 31)
        ]
        session.connection().execute(insert(SearchTrack.__table__), tracks)
    world = IndexedLibrary(database, tmp_path / "home")
    began = time.process_time()
    assert len(world.labelled.find(TrackQuery(label="stop", state="accepted")).videos) == videos
    assert len(world.labelled.find(TrackQuery(label="yield")).videos) == videos
    took = (time.process_time() - began) / 2
    print(f"{took:.2f} s a question")
    assert took < 1.2
    world.evidence.close()
    database.close()


def test_videos_are_matched_over_http(api: ExchangeClient, find: Callable[..., Any]) -> None:
    tracks = list(api.tracks().values())
    stops = sum(track.label == STOP for track in tracks)
    assert find(label="stop") == ({api.video_id: stops} if stops else {})
    assert find() == {api.video_id: len(tracks)}
    answer = api.server.client.get("/api/videos/matching?value=yes")
    assert answer.json()["error"]["field"] == "attribute"
    assert "boar" in json.dumps(api.server.client.get("/api/videos/matching?label=boar").json())


@pytest.fixture
def find(api: ExchangeClient) -> Callable[..., Any]:
    """Return a function that queries the server."""

    def ask(**wanted: str) -> Any:
        answer = api.server.client.get("/api/videos/matching", params=wanted)
        assert answer.status_code == 200, answer.text
        assert answer.json()["left"] == 0
        return answer.json()["videos"]

    return ask
