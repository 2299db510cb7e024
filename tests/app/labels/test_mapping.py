"""A run's classes as labels of the video's set, in everything that reads evidence."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from app.compare.service import CompareService
from app.edits.commands import RelabelTrack, Split
from app.edits.documents import NO_CLASS
from app.edits.log_store import LogStore
from app.edits.service import EditService
from app.ground_truths.service import GroundTruthService
from app.labels.store import start
from app.storage.ground_truth_rows import pack
from app.storage.models import GroundTruth, Video
from tests.app import toy_home
from tsr_engine.labels.files import shipped_set
from tsr_engine.labels.model import Label, LabelSet


@pytest.fixture
def home(tmp_path: Any) -> Iterator[Any]:
    home = toy_home.make_home(tmp_path)
    yield home
    home.evidence.close()
    home.database.close()


def use(home: Any, labels: LabelSet) -> None:
    """Give the video this set."""
    with home.database.write() as session:
        start(session, labels, "ann", "Made.")
        session.get_one(Video, home.video_id).label_set = labels.key


def columns(home: Any, run: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(home.evidence.tracks(run))
    return found


def test_classes_of_the_model_missing_from_the_set(home: Any) -> None:
    before = columns(home, home.run_id)
    assert before["word"] == [None] * len(before["id"])
    gtsrb = shipped_set("gtsrb-43")
    first = before["class_id"][0]
    word = gtsrb.labels[first].name
    kept = [label for label in gtsrb.labels if label.id != first]
    use(home, LabelSet(key="ours", name="Ours", next_id=43, labels=tuple(kept)))
    run = home.run_id
    after = columns(home, run)
    assert after["class_id"] == [NO_CLASS if label == first else label for label in before["class_id"]]
    assert after["word"] == [word if label == first else None for label in before["class_id"]]
    assert any(f"'{word}' has" in text for text in after["reasons"][0]) == any(
        f"'{word}' has" in text for text in before["reasons"][0]
    )
    track = after["id"][0]
    assert home.evidence.label(run, track) == NO_CLASS
    lane = home.evidence.track(run, track)
    assert (lane.classes[0], lane.words[0]) == (NO_CLASS, word)
    assert all((seen == NO_CLASS) == (read is not None) for seen, read in zip(lane.top, lane.top_word, strict=True))
    seen = [t for frame in home.evidence.overlays(run, 0, 74) for t in frame.tracks if t.id == track]
    assert {(t.class_id, t.word) for t in seen if t.class_id is not None and t.word is not None} == {(NO_CLASS, word)}
    ground_truths = GroundTruthService(home.database)
    edits = EditService(LogStore(home.database, home.events, home.evidence))
    compare = CompareService(home.database, home.evidence, ground_truths)
    found = compare.compare(f"run:{run}", f"annotation:{run}")
    assert found.confusion.words == {-10: word}
    assert {(cell.reference, cell.candidate) for cell in found.confusion.cells if cell.reference == -10} == {(-10, -10)}
    frames = home.evidence.span(run, track)
    split = Split(name="split", key=f"m{track}", frame=sum(frames) // 2, new_key="hlater01")
    edits.apply(run, "op-000001", "ann", split, {f"m{track}": 0})
    assert {cell.candidate for cell in compare.compare(f"run:{run}", f"annotation:{run}").confusion.cells} >= {-10}


def test_merged_labels_are_one(home: Any) -> None:
    before = columns(home, home.run_id)
    one = before["class_id"][0]
    two = (one + 1) % 43
    gtsrb = shipped_set("gtsrb-43")
    joined = [label.model_copy(update={"merged_into": two}) if label.id == one else label for label in gtsrb.labels]
    use(home, LabelSet(key="ours", name="Ours", next_id=43, labels=tuple(joined)))
    after = columns(home, home.run_id)
    assert after["class_id"] == [two if label == one else label for label in before["class_id"]]
    edits = EditService(LogStore(home.database, home.events, home.evidence))
    key = f"m{before['id'][0]}"
    edits.apply(
        home.run_id, "op-000001", "ann", RelabelTrack(name="relabel_track", key=key, frame=0, class_id=two), {key: 0}
    )
    boxes = home.evidence.boxes(home.run_id)
    rows = np.zeros((len(boxes), 9))
    rows[:, 0], rows[:, 1], rows[:, 2:6], rows[:, 6] = boxes.frame, boxes.track, boxes.boxes, one
    with home.database.write() as session:
        session.add(GroundTruth(id="e" * 32, video_id=home.video_id, name="t", boxes=pack(rows), count=len(rows)))
    compare = CompareService(home.database, home.evidence, GroundTruthService(home.database))
    corrected = compare.compare(f"truth:{'e' * 32}", f"annotation:{home.run_id}").confusion
    assert {cell.reference for cell in corrected.cells} <= {two, None}
    assert [cell.count for cell in corrected.cells if (cell.reference, cell.candidate) == (two, two)] == [
        int(np.isin(boxes.class_id, [one, two]).sum())
    ]
    again = columns(home, home.run_id)
    assert again["rank"] == again["uncertainty"], "another label that was merged into the engine's is no contradiction"


def test_the_label_in_another_run(home: Any) -> None:
    """A run with classes of other names, and a run with ids of the set."""
    gtsrb = shipped_set("gtsrb-43")
    keys = [label.key for label in gtsrb]
    class_id = columns(home, home.run_id)["class_id"][0]
    keys[class_id] = "bus stop"
    more = Label(id=60, key="bus-stop", name="Bushaltestelle")
    use(home, LabelSet(key="ours", name="Ours", next_id=61, labels=(*gtsrb.labels, more)))
    folder = f"runs/{home.run_id}"
    other = home.add_run(folder=folder, name="Theirs", labels={"keys": keys})
    assert columns(home, other)["class_id"][0] == 60
    assert any("Theirs labels it 'Bushaltestelle'." in text for text in columns(home, home.run_id)["reasons"][0])
    of_set = home.add_run(folder=folder, name="Imported", labels={"set": "ours"})
    assert columns(home, of_set)["class_id"][0] == class_id


def test_a_change_of_the_set_shows_at_once(home: Any) -> None:
    first = columns(home, home.run_id)["class_id"][0]
    gtsrb = shipped_set("gtsrb-43")
    named = [label.model_copy(update={"name": "Mine"}) if label.id == first else label for label in gtsrb.labels]
    with home.database.write() as session:
        start(session, gtsrb.model_copy(update={"labels": tuple(named), "version": 2}), "ann", "Renamed.")
    text = json.dumps(columns(home, home.run_id)["reasons"])
    assert gtsrb.labels[first].name not in text
