"""The log: revisions, undo, conflicts, concurrent edits, kills and full disks."""

from __future__ import annotations

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from pydantic import TypeAdapter
from sqlalchemy import func, select

from app.edits.commands import Command, Redo, Undo
from app.edits.documents import OPEN_END, KeyFrame, Note, TrackDoc
from app.edits.effective import box_at
from app.edits.views import EditAnswer
from app.errors import Conflict, Invalid, NotFound, PreconditionRequired
from app.storage.models import Edit, Event, Run, Video
from tests.app.edits.edit_services import FRAMES, VIDEO, EditServices
from tests.app.edits.random_commands import engine_box, initial_documents, random_command
from tests.waiting import TIME_FACTOR

ADAPTER: TypeAdapter[Any] = TypeAdapter(Command)


def send(
    edits: EditServices, op: str, raw: dict[str, Any], expected: dict[str, int] | None, author: str = "ann"
) -> EditAnswer:
    return edits.service.apply(edits.run, f"op-{op:0>8}", author, ADAPTER.validate_python(raw), expected)


def undo_or_redo(
    edits: EditServices, op: str, kind: type[Undo] | type[Redo], target: str, author: str = "ann"
) -> EditAnswer:
    name: Any = "undo" if kind is Undo else "redo"
    return edits.service.apply(edits.run, f"op-{op:0>8}", author, kind(name=name, op_id=target), None)


def content(edits: EditServices) -> dict[str, Any]:
    """Documents without revisions, unchanged tracks and removed drawn tracks."""
    fresh = {key: doc.model_dump(exclude={"revision"}) for key, doc in initial_documents().items()}
    docs = {key: doc.model_dump(exclude={"revision"}) for key, doc in edits.documents().items()}
    return {k: d for k, d in docs.items() if d != fresh.get(k) and not (k.startswith("h") and d["gone"])}


def relabel(label: int, key: str = "m1") -> dict[str, Any]:
    return {"name": "relabel_track", "frame": 3, "key": key, "class_id": label}


def test_missing_stale_and_repeated_revisions(edits: EditServices) -> None:
    with pytest.raises(PreconditionRequired):
        send(edits, "1", relabel(3), None)
    first = send(edits, "1", relabel(3), {"m1": 0})
    assert first.docs[0].revision == 1
    again = send(edits, "1", relabel(3), {"m1": 0})
    assert again.docs == first.docs
    with pytest.raises(Conflict) as caught:
        send(edits, "2", relabel(9), {"m1": 0}, "bob")
    details = caught.value.details
    assert details is not None
    assert (details["current"][0]["class_id"], details["yours"][0]["class_id"]) == (3, 9)
    assert len(edits.service.log(edits.run, 0)) == 1
    with pytest.raises(NotFound):
        edits.service.annotation("0" * 32, "ann")
    with pytest.raises(Invalid):
        send(edits, "3", relabel(9, "m77"), {})
    with edits.database.read() as session:
        assert session.scalar(select(func.count()).select_from(Event).where(Event.kind == "edit")) == 1


def test_a_number_with_zeros_names_no_track(edits: EditServices) -> None:
    send(edits, "1", {"name": "add_note", "frame": 5, "key": "m1", "note_id": "n1", "text": "bent"}, {"m1": 0})
    with pytest.raises(Invalid):
        send(edits, "2", {"name": "set_review", "frame": 5, "key": "m001", "review": "accepted"}, {"m001": 0}, "bob")
    assert [note.text for note in edits.documents()["m1"].notes] == ["bent"]


@pytest.mark.parametrize("reported", [{}, {"class_id": 2}])
def test_a_split_inherits_the_class_of_the_evidence(edits: EditServices, reported: dict[str, int]) -> None:
    send(edits, "1", {"name": "set_box", "frame": 30, "key": "m1", "box": [0.0, 0.0, 9.0, 9.0]}, {"m1": 0})
    whole = content(edits)
    split = {"name": "split", "frame": 25, "key": "m1", "new_key": "hlater01", **reported}
    docs = {doc.key: doc for doc in send(edits, "2", split, {"m1": 1}).docs}
    assert (docs["m1"].class_id, docs["hlater01"].class_id) == (None, 14)
    undo_or_redo(edits, "3", Undo, "op-00000002")
    assert content(edits) == whole
    again = {doc.key: doc for doc in undo_or_redo(edits, "4", Redo, "op-00000002").docs}
    assert again["hlater01"].class_id == 14
    # an unrecognised track has no class to inherit
    send(edits, "5", {"name": "set_box", "frame": 60, "key": "m2", "box": [0.0, 0.0, 9.0, 9.0]}, {"m2": 0})
    split = {"name": "split", "frame": 55, "key": "m2", "new_key": "hlater02", **reported}
    assert {doc.key: doc.class_id for doc in send(edits, "6", split, {"m2": 1}).docs} == {"m2": None, "hlater02": None}


@pytest.mark.parametrize("reported", [{}, {"class_id": 2}])
@pytest.mark.parametrize(("other", "label"), [("m1", 38), ("hlater02", None)])
def test_a_merge_keeps_the_label_that_the_track_showed(
    edits: EditServices, reported: dict[str, int], other: str, label: int | None
) -> None:
    """An earlier engine track into a part of m3, and a later part of the same track into it."""
    for step, (frame, key) in enumerate([(65, "hlater02"), (60, "hlater01")]):
        split = {"name": "split", "frame": frame, "key": "m3", "new_key": key}
        send(edits, f"{step}", split, {"m3": step})
    merge = {"name": "merge", "frame": 60, "key": "hlater01", "others": [other], **reported}
    revisions = {"hlater01": 1, other: int(other == "hlater02")}
    docs = {doc.key: doc for doc in send(edits, "2", merge, revisions).docs}
    assert docs["hlater01"].class_id == label
    assert docs[other].merged_into == "hlater01"


@pytest.mark.parametrize("seed", range(3))
def test_undoing_and_redoing_all_edits(edits: EditServices, seed: int) -> None:
    rng, docs, states = random.Random(seed), initial_documents(), []
    for step in range(25):
        states.append(content(edits))
        try:
            answer = send(
                edits, f"{seed}x{step}", random_command(rng, docs, step), {k: d.revision for k, d in docs.items()}
            )
        except Invalid:
            states.pop()
            continue
        docs |= {doc.key: doc for doc in answer.docs}
    end, count = content(edits), 0
    revisions = {key: doc.revision for key, doc in edits.documents().items()}
    for state in reversed(states):
        target = edits.service.annotation(edits.run, "ann").undo
        assert target is not None
        undo_or_redo(edits, f"u{seed}x{count}", Undo, target.op_id)
        count += 1
        assert content(edits) == state
    assert edits.service.annotation(edits.run, "ann").undo is None
    assert content(edits) == {}
    while (target := edits.service.annotation(edits.run, "ann").redo) is not None:
        undo_or_redo(edits, f"r{seed}x{count}", Redo, target.op_id)
        count += 1
    assert content(edits) == end
    assert all(edits.documents()[key].revision > old for key, old in revisions.items())


@pytest.mark.parametrize(
    ("raw", "field"),
    [
        ({"name": "set_box", "frame": FRAMES, "box": [0.0, 0.0, 9.0, 9.0]}, "frame"),
        ({"name": "add_note", "frame": OPEN_END, "note_id": "n", "text": "far"}, "frame"),
        ({"name": "interpolate", "frame": 3, "first": FRAMES, "last": FRAMES}, "first"),
        ({"name": "interpolate", "frame": 3, "first": 0, "last": 20_000_000}, "last"),
    ],
)
def test_frames_outside_the_video_are_refused(edits: EditServices, raw: dict[str, Any], field: str) -> None:
    with pytest.raises(Invalid, match=rf"frames 0 to {FRAMES - 1}\. Got \d+\.") as caught:
        send(edits, "1", {"key": "m1", **raw}, {"m1": 0})
    assert (caught.value.field, caught.value.code) == (f"command.{field}", "no_such_frame")
    assert edits.service.log(edits.run, 0) == []
    last = {"name": "set_box", "frame": FRAMES - 1, "key": "m1", "box": [0.0, 0.0, 9.0, 9.0]}
    open_piece = {"track": 1, "first": 0, "last": OPEN_END}  # as a page sends it during the run
    assert send(edits, "2", {**last, "spans": [open_piece]}, {"m1": 0}).docs[0].frames() == [FRAMES - 1]


def test_imported_documents_end_with_the_video(edits: EditServices) -> None:
    drawn = TrackDoc(key="hdrawn01", keys={"0": KeyFrame(box=(0, 0, 9, 9))})
    far = drawn.model_copy(update={"keys": {**drawn.keys, str(FRAMES): KeyFrame(box=(0, 0, 9, 9))}})
    noted = drawn.model_copy(update={"notes": (Note(id="n", frame=FRAMES, text="far", author="ann", time=""),)})
    command = {"name": "import"}

    def first(document: TrackDoc) -> None:
        with edits.database.write() as session:
            run = session.get_one(Run, edits.run)
            edits.bulk.record(session, run, "ann", command, {"hdrawn01": drawn}, {"hdrawn01": document})

    for document in (far, noted):
        with pytest.raises(Invalid, match=f"Track hdrawn01: .* Got {FRAMES}"):
            edits.bulk.put_documents(edits.run, "ann", command, lambda _, d=document: {d.key: d})
        with pytest.raises(Invalid, match="Track hdrawn01"):
            first(document)
    assert edits.documents() == {}
    first(drawn)
    assert edits.documents()["hdrawn01"].has_same_content(drawn)


def test_a_video_being_imported_has_its_known_frames(edits: EditServices) -> None:
    """A bundle's clip is imported after its run."""

    def known(state: str, frames: int | None, stop: int | None) -> None:
        with edits.database.write() as session:
            video = session.get_one(Video, VIDEO)
            video.state, video.frames, session.get_one(Run, edits.run).stop = state, frames, stop

    known("importing", None, None)
    with pytest.raises(Conflict, match="not known yet"):
        send(edits, "1", relabel(3), {"m1": 0})
    for step, (frames, stop) in enumerate(((None, 4), (4, None), (2, 4), (4, 2))):
        known("importing", frames, stop)
        assert send(edits, f"2{step}", relabel(step), {"m1": step}).docs[0].class_id == step
        with pytest.raises(Invalid, match="0 to 3"):
            send(edits, "3", {**relabel(3), "frame": 4}, {"m1": step + 1})
    known("ready", 3, 4)
    with pytest.raises(Invalid, match="0 to 2"):
        send(edits, "4", relabel(3), {"m1": 4})


def test_undo_is_refused_after_somebody_elses_change(edits: EditServices) -> None:
    send(edits, "1", relabel(3), {"m1": 0})
    send(edits, "2", relabel(4), {"m1": 1}, "bob")
    with pytest.raises(Conflict):
        undo_or_redo(edits, "3", Undo, "op-00000001")
    undo_or_redo(edits, "4", Undo, "op-00000002", "bob")
    undo_or_redo(edits, "5", Undo, "op-00000001")
    assert content(edits) == {}


def test_a_growing_track_stays_open_until_the_run_is_complete(edits: EditServices) -> None:
    with edits.database.write() as session:
        session.get_one(Run, edits.run).state = "running"
    doc = send(edits, "1", relabel(3), {"m1": 0}).docs[0]
    assert doc.segments[0].last == OPEN_END
    cut = send(edits, "2", {"name": "delete_from", "frame": 60, "key": "m3"}, {"m3": 0}).docs[0]
    assert cut.segments[0].last == 59
    edits.evidence.spans[1] = (0, 33)
    with edits.database.write() as session:
        session.get_one(Run, edits.run).state = "complete"
    doc = send(edits, "3", {"name": "set_review", "frame": 3, "key": "m1", "review": "accepted"}, {"m1": 1}).docs[0]
    assert doc.segments[0].last == 33
    undo_or_redo(edits, "4", Undo, "op-00000003")
    undo_or_redo(edits, "5", Undo, "op-00000002")
    undo_or_redo(edits, "6", Undo, "op-00000001")


@pytest.mark.parametrize(("key", "other"), [("m1", "m3"), ("m3", "m1"), ("m1", "hdrawn1")])
def test_a_merge_during_a_run_keeps_boxes_after_the_end_of_a_track(edits: EditServices, key: str, other: str) -> None:
    """m1 has ended at frame 20, but its document stays open until the run is complete."""
    with edits.database.write() as session:
        session.get_one(Run, edits.run).state = "running"
    send(edits, "1", {"name": "create_track", "frame": 60, "key": "hdrawn1", "box": [0, 0, 9, 9]}, {})
    revisions = {key: 0, other: int(other == "hdrawn1")}
    send(edits, "2", {"name": "merge", "frame": 60, "key": key, "others": [other]}, revisions)
    with edits.database.write() as session:
        session.get_one(Run, edits.run).state = "complete"
    answer = send(edits, "3", {"name": "set_review", "frame": 60, "key": key, "review": "accepted"}, {key: 1})
    boxes = {f for f in range(FRAMES) if box_at(answer.docs[0], f, engine_box)}
    assert boxes >= {0, 20 - 1, 60}


def test_twenty_clients_at_once_lose_nothing(edits: EditServices) -> None:
    """No edit is lost and no client starves. Times vary on a busy machine: `TSR_TIMES=1` checks the goal."""
    took: list[float] = []
    passed: list[int] = []

    def client(number: int) -> None:
        known = 0
        for step in range(10):
            raw = {"name": "add_note", "frame": 1, "key": "m1", "note_id": f"{number}-{step}", "text": "x"}
            started = time.perf_counter()
            while True:
                try:
                    answer = send(edits, f"{number}x{step}", raw, {"m1": known}, f"c{number}")
                except Conflict as error:
                    known = (error.details or {})["current"][0]["revision"]
                    continue
                known = answer.docs[0].revision
                break
            took.append(time.perf_counter() - started)

    def alone(number: int) -> None:
        """Each client edits its own track, the common case."""
        key = f"hown{number:04d}"
        make = {"name": "create_track", "frame": 0, "key": key, "box": [0.0, 0.0, 9.0, 9.0]}
        known = send(edits, f"c{number}", make, {}).docs[0].revision
        for step in range(10):
            started, before = time.perf_counter(), len(took)
            known = send(edits, f"a{number}x{step}", relabel(step, key), {key: known}).docs[0].revision
            took.append(time.perf_counter() - started)
            passed.append(len(took) - before)
            time.sleep(0.1)

    with ThreadPoolExecutor(20) as pool:
        list(pool.map(client, range(4)))
        contended = len(took)
        took.clear()
        list(pool.map(alone, range(20)))
    assert contended == 40
    docs = edits.documents()
    assert len(docs["m1"].notes) == 40
    assert all(docs[f"hown{n:04d}"].revision == 11 for n in range(20))
    p95, behind = (sorted(some)[int(0.95 * len(some))] for some in (took, passed))
    print(f"20 clients: p95 {1000 * p95:.0f} ms, {behind} answers given before")
    assert behind <= 3 * 20
    assert TIME_FACTOR > 1 or p95 < 0.2


CHILD = """
import sys
from tests.app.edits.edit_services import make_edit_services
from tests.app.edits.test_service import relabel, send
edits = make_edit_services("sqlite:///" + sys.argv[1])
if len(sys.argv) > 3:
    import resource, signal
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[3]), resource.RLIM_INFINITY))
from sqlalchemy.exc import DBAPIError
from app.storage.database import storage_failure
known, full = 0, False
for step in range(100000):
    try:
        known = send(edits, str(step), relabel(step % 43), {"m1": known}).docs[0].revision
        print(step, flush=True)
    except DBAPIError as error:
        if full:
            raise
        failure = storage_failure(error)
        told = f"{failure.status}:{failure.code}" if failure else error
        print("full", told, len(edits.service.log(edits.run, 0, 10**6)), flush=True)
        resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        full = True
    if full and known and step % 10 == 0:
        break
"""


def _child(file: Path, *more: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", CHILD, str(file), str(Path(__file__).parent), *more]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[3])


@pytest.mark.parametrize("after", [1, 40])
def test_kill_keeps_every_acknowledged_edit(tmp_path: Path, after: int) -> None:
    file = tmp_path / "t.sqlite"
    with _child(file) as child:
        assert child.stdout is not None
        reported = [int(child.stdout.readline()) for _ in range(after)]
        os.kill(child.pid, signal.SIGKILL)
        reported += [int(line) for line in child.stdout.read().split("\n") if line.strip()]
    with sqlite3.connect(file) as database:
        stored = {row[0] for row in database.execute("SELECT op_id FROM edits")}
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        revision = database.execute("SELECT revision FROM track_documents").fetchone()[0]
    database.close()
    assert {f"op-{step:0>8}" for step in reported} <= stored
    assert revision == len(stored)


def test_a_file_size_limit_is_reported_and_temporary(tmp_path: Path) -> None:
    with _child(tmp_path / "t.sqlite", "600000") as child:
        assert child.stdout is not None
        lines = child.stdout.read().split()
    assert child.returncode == 0
    where = lines.index("full")
    assert lines[where + 1] == "507:storage_limit"
    assert int(lines[where + 2]) == where, "acknowledged rows were lost"
    assert len(lines) > where + 3, "no edit went through once there was room again"


def test_documents_round_trip(edits: EditServices) -> None:
    answer = send(edits, "1", {"name": "set_box", "frame": 4, "key": "m1", "box": [0.1, 0.2, 0.7, 1e4 / 3]}, {"m1": 0})
    assert edits.documents()["m1"] == answer.docs[0]
    assert TrackDoc.model_validate_json(answer.docs[0].model_dump_json()) == answer.docs[0]
    with edits.database.read() as session:
        assert session.scalars(select(Edit)).one().command["box"] == [0.1, 0.2, 0.7, 1e4 / 3]
