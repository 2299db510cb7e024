"""Label sets of a library on SQLite and PostgreSQL: versions, authors, times, concurrent changes, refusals."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter
from sqlalchemy import select

from app.errors import Conflict, Invalid, NotFound
from app.labels.commands import LabelChange
from app.labels.service import LabelService
from app.labels.views import Change
from app.storage.database import Database
from app.storage.ground_truth_rows import pack
from app.storage.models import Edit, Event, GroundTruth, LabelSetVersion, Run, TrackDocument, Video
from tsr_engine.labels.files import shipped_set
from tsr_engine.labels.model import Label, LabelSet

GTSRB = "gtsrb-43"
VIDEO = "a" * 64
_CHANGE: TypeAdapter[LabelChange] = TypeAdapter(LabelChange)


def change(service: LabelService, author: str, key: str = GTSRB, **fields: Any) -> Change:
    return service.change(key, author, _CHANGE.validate_python(fields))


def add(service: LabelService, name: str, author: str = "ada") -> int:
    label = change(service, author, type="add", name=name).label
    assert label is not None
    return label.id


def own_set(database: Database, key: str, *labels: Label) -> None:
    """A set of the library in addition to the shipped ones."""
    from app.labels.store import start

    with database.write() as session:
        start(session, LabelSet(key=key, name=key.upper(), next_id=100, labels=labels), "ada", "Made.")


def add_video(database: Database, video_id: str = VIDEO, **fields: Any) -> str:
    """A video with a run; returns its name."""
    run = video_id[:32]
    with database.write() as session:
        session.add(Video(id=video_id, name="a.mp4", path="/a.mp4", size=1, state="ready", **fields))
        session.flush()
        session.add(Run(id=run, video_id=video_id, state="complete"))
    return run


def test_a_new_library_uses_the_43_and_stores_nothing(labels: LabelService, database: Database) -> None:
    assert [view.id for view in labels.labels()] == list(range(43))
    assert labels.get(None) == shipped_set(GTSRB)
    first = labels.sets()[0]
    assert (first.key, first.version, first.labels, first.default, first.shipped) == (GTSRB, 1, 43, True, True)
    (version,) = labels.history(GTSRB)
    assert (version.version, version.author, version.created, version.sentence) == (1, "", None, "Came with tsr.")
    with database.read() as session:
        assert not session.scalars(select(LabelSetVersion.version)).all()


def test_versions_name_author_and_change_and_are_immutable(labels: LabelService, database: Database) -> None:
    new = add(labels, "no parking")
    assert new == 43
    done = change(
        labels, "bob", type="update", id=43, name="no stopping", attributes=[{"name": "a", "kind": "checkbox"}]
    )
    assert done.version == 3
    assert done.label is not None
    assert done.label.attributes[0].kind == "checkbox"
    versions = labels.history(GTSRB)
    assert [(v.version, v.author, v.sentence) for v in versions] == [
        (3, "bob", "Changed name and attributes of 'no parking', now 'no stopping'."),
        (2, "ada", "Added 'no parking'."),
        (1, "", "Came with tsr."),
    ]
    assert all(version.created for version in versions)
    assert labels.get(GTSRB, 1) == shipped_set(GTSRB)
    assert labels.get(GTSRB, 2).get(43).name == "no parking"  # type: ignore[union-attr]
    assert labels.get(None).version == 3
    with pytest.raises(NotFound, match="has no version 4"):
        labels.get(GTSRB, 4)
    with database.read() as session:
        events = session.scalars(select(Event).where(Event.kind == "labels")).all()
    assert [(event.subject, event.data) for event in events] == [(GTSRB, {"version": 2}), (GTSRB, {"version": 3})]


def test_a_change_without_effect_makes_no_version(labels: LabelService) -> None:
    add(labels, "no parking")
    assert change(labels, "ada", type="update", id=43, name="no parking").version == 2
    assert len(labels.history(GTSRB)) == 2


def test_a_second_addition_of_a_label_names_the_first_author(labels: LabelService) -> None:
    add(labels, "No parking", "ada")
    with pytest.raises(Conflict) as refused:
        add(labels, "no_parking", "bob")
    error = refused.value
    assert (error.status, error.code, error.field) == (409, "taken", "name")
    assert error.message == (
        "The name 'no_parking' belongs to 'No parking' (label 43, key no-parking). It was added by ada."
    )
    assert error.details is not None
    assert error.details["label"]["id"] == 43
    assert error.details["by"]["author"] == "ada"
    with pytest.raises(Conflict) as refused:
        add(labels, "Stop")
    assert refused.value.details is not None
    assert refused.value.details["by"] is None


def test_simultaneous_changes_are_all_stored(labels: LabelService) -> None:
    ready = threading.Barrier(6)

    def work(person: int) -> list[int]:
        ready.wait()
        return [add(labels, f"sign {person} {number}", f"person {person}") for number in range(4)]

    with ThreadPoolExecutor(6) as pool:
        given = [number for numbers in pool.map(work, range(6)) for number in numbers]
    assert sorted(given) == list(range(43, 67))
    now = labels.get(None)
    assert now.version == 25
    assert len(now) == 67
    assert [version.version for version in labels.history(GTSRB)] == list(range(25, 0, -1))


def test_one_of_two_simultaneous_additions_is_refused(labels: LabelService) -> None:
    ready = threading.Barrier(2)

    def work(person: str) -> int | str:
        ready.wait()
        try:
            return add(labels, "no parking", person)
        except Conflict as error:
            return str((error.details or {})["by"]["author"])

    with ThreadPoolExecutor(2) as pool:
        answers = dict(zip(("ada", "bob"), pool.map(work, ("ada", "bob")), strict=True))
    winner = next(person for person, answer in answers.items() if answer == 43)
    assert set(answers.values()) == {43, winner}


def test_undo_makes_a_version_and_can_be_undone(labels: LabelService) -> None:
    change(labels, "ada", type="merge", id=14, into=13)
    done = change(labels, "bob", type="undo", version=2)
    assert done.version == 3
    assert done.sentence == "Took back version 2: Merged 'stop' into 'give way'."
    assert labels.get(None).labels == shipped_set(GTSRB).labels
    assert labels.history(GTSRB)[0].undoes == 2
    change(labels, "bob", type="undo", version=3)
    assert labels.get(None).resolved(14) == 13
    with pytest.raises(Invalid, match="no change to undo"):
        change(labels, "ada", type="undo", version=1)
    with pytest.raises(NotFound, match="no version 9"):
        change(labels, "ada", type="undo", version=9)


def test_undo_hides_an_added_label_in_use(labels: LabelService, database: Database) -> None:
    run = add_video(database)
    document = {"key": "m1", "keys": {"3": {"class_id": 44}}, "class_id": None}
    edit = {"op_id": "x" * 8, "run_id": run, "author": "ada", "kind": "relabel_track", "command": {}, "frame": 0}
    truth = np.array([[0, 1, 10, 20, 30, 40, 46, 1, 0], [0, 2, 10, 20, 30, 40, -1, 1, 0]], np.float64)
    for name in ("unused", "in a document", "in the log", "in a truth", "unused too"):
        add(labels, name)
    with database.write() as session:
        session.add(TrackDocument(run_id=run, key="m1", revision=1, document=document))
        session.add(Edit(**edit, before={"m1": {"class_id": 45}}, after={"m1": {"class_id": 4}}))
        session.add(GroundTruth(id="b" * 32, video_id=VIDEO, name="t", boxes=pack(truth), count=2))
    for version in (2, 3, 4, 5, 6):
        change(labels, "ada", type="undo", version=version)
    now = labels.get(None)
    assert [(label.id, label.hidden) for label in now if label.id > 42] == [(44, True), (45, True), (46, True)]
    assert now.next_id == 48
    assert add(labels, "unused") == 48


def test_undo_hides_a_label_of_an_imported_run(labels: LabelService, database: Database) -> None:
    run = add_video(database)
    add(labels, "no parking")
    with database.write() as session:
        session.get(Run, run).labels = {"set": GTSRB}  # type: ignore[union-attr]
    change(labels, "ada", type="undo", version=2)
    assert labels.get(None).get(43).hidden  # type: ignore[union-attr]


def test_a_video_changes_its_set_unless_labels_would_change_meaning(labels: LabelService, database: Database) -> None:
    run = add_video(database)
    stop = shipped_set(GTSRB).get(14)
    assert stop is not None
    own_set(database, "signs", Label(id=13, key="other", name="other"), stop)
    assert labels.use_in_video(VIDEO, "signs").key == "signs"
    assert [view.id for view in labels.labels(VIDEO)] == [13, 14]
    assert labels.use_in_video(VIDEO, None).key == GTSRB
    with database.write() as session:
        session.add(TrackDocument(run_id=run, key="m1", revision=1, document={"class_id": 14}))
    assert labels.use_in_video(VIDEO, "signs").key == "signs"
    labels.use_in_video(VIDEO, None)
    with database.write() as session:
        session.get(TrackDocument, (run, "m1")).document = {"class_id": 13}  # type: ignore[union-attr]
    with pytest.raises(Conflict, match="use label 13, 'give way', which is 'other' in 'SIGNS'") as refused:
        labels.use_in_video(VIDEO, "signs")
    assert refused.value.code == "labels_in_use"
    with pytest.raises(Conflict, match="use label 13"):
        labels.use_as_default("signs")
    assert labels.get(None).key == GTSRB
    with pytest.raises(NotFound, match="no label set 'none'"):
        labels.use_in_video(VIDEO, "none")
    with pytest.raises(NotFound, match="no video"):
        labels.use_in_video("b" * 64, "signs")


def test_videos_without_a_set_use_the_default(labels: LabelService, database: Database) -> None:
    add_video(database)
    own_set(database, "signs", Label(id=0, key="a", name="a"))
    assert labels.use_as_default("signs").default
    assert labels.of_video(VIDEO).key == "signs"
    assert [(view.key, view.default) for view in labels.sets() if view.default] == [("signs", True)]
    assert labels.use_as_default(GTSRB).key == GTSRB
    assert labels.of_video(VIDEO).key == GTSRB


def test_labels_of_another_set_get_new_ids(labels: LabelService, database: Database) -> None:
    own_set(database, "signs", Label(id=3, key="no-parking", name="no parking"), Label(id=5, key="STOP", name="halt"))
    done = change(labels, "ada", type="adopt", set="signs")
    assert done.sentence == "Added 1 label of 'SIGNS'."
    assert labels.get(None).by_key("no-parking").id == 43  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "name",
    [
        "<img src=x onerror=alert(1)>",
        "تقاطع",
        "🚸 children",
        "Überholverbot für Lkw",
        "停",
        "'; DROP TABLE label_sets; --",
    ],
)
def test_any_plain_name_is_kept(labels: LabelService, name: str) -> None:
    number = add(labels, name)
    assert labels.label(None, number).name == name
    assert labels.history(GTSRB)[0].sentence == f"Added '{name}'."


@pytest.mark.parametrize("name", ["a\x00b", "a\nb", "\u202egnikrap on", " "])
def test_names_that_are_not_plain_text_are_refused(labels: LabelService, name: str) -> None:
    with pytest.raises(Invalid):
        add(labels, name)
