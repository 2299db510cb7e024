"""Simultaneous edits on both databases: each is applied once or reported as stale, and none fails."""

from __future__ import annotations

from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from app.edits.commands import Command, Undo
from app.errors import Conflict
from app.storage.models import Run
from tests.app.edits.edit_services import EditServices
from tsr_engine.track_table import TrackTable

ADAPTER: TypeAdapter[Any] = TypeAdapter(Command)
MANY = 8


def relabel(label: int, key: str) -> Any:
    return ADAPTER.validate_python({"name": "relabel_track", "frame": 3, "key": key, "class_id": label})


def run_concurrently(work: Any) -> Counter[str]:
    """Run an action in many threads at once; returns the count of each outcome."""
    barrier = Barrier(MANY)

    def one(number: int) -> str:
        barrier.wait()
        try:
            work(number)
        except Conflict as conflict:
            return conflict.code
        return "done"

    with ThreadPoolExecutor(MANY) as pool:
        return Counter(pool.map(one, range(MANY)))


def test_only_one_of_several_first_edits_succeeds(edits: EditServices) -> None:
    for track in (1, 2, 3):
        key = f"m{track}"

        def touch(number: int, key: str = key) -> None:
            edits.service.apply(edits.run, f"op-{key}-{number:05d}", f"p{number}", relabel(number, key), {key: 0})

        assert run_concurrently(touch) == {"done": 1, "stale": MANY - 1}
    assert len(edits.service.log(edits.run, 0)) == 3


def test_simultaneous_equal_operations_are_one_row(edits: EditServices) -> None:
    answers = []

    def send(_: int) -> None:
        answers.append(edits.service.apply(edits.run, "op-same-0000", "ann", relabel(3, "m1"), {"m1": 0}))

    assert run_concurrently(send) == {"done": MANY}
    assert all(answer == answers[0] for answer in answers)
    assert len(edits.service.log(edits.run, 0)) == 1


def test_simultaneous_undos_are_one_undo(edits: EditServices) -> None:
    for step in range(3):
        edits.service.apply(edits.run, f"op-base-{step}", "ann", relabel(step, "m1"), {"m1": step})

    def back(number: int) -> None:
        edits.service.apply(edits.run, f"op-undo-{number}", "ann", Undo(name="undo", op_id="op-base-2"), None)

    assert run_concurrently(back) == {"done": 1, "not_next": MANY - 1}
    assert edits.documents()["m1"].class_id == 1


def test_simultaneous_adoption_and_edits(edits: EditServices) -> None:
    """No deadlock, and no edit is lost."""
    other = "c" * 32
    with edits.database.write() as session:
        session.add(Run(id=other, video_id="f" * 64, state="complete", parameters={}, models={}, summary={}))
    rows = [(f, t) for t, (a, b) in edits.evidence.spans.items() for f in range(a, b + 1)]
    frame, track = np.array(rows).T
    boxes = np.stack([100.0 * track, 0.0 * track, 100.0 * track + 20, 0.0 * track + 20], 1)
    table = TrackTable(frame, track - 1, boxes, frame * 0, names=("m1", "m2", "m3"))
    edits.evidence.boxes = lambda _run: table  # type: ignore[attr-defined]
    for key in ("m1", "m2", "m3"):
        edits.service.apply(edits.run, f"op-from-{key}", "ann", relabel(7, key), {key: 0})

    def work(number: int) -> None:
        if number % 2:
            edits.bulk.adopt(other, edits.run, "ann")
        else:
            key = f"m{1 + number % 3}"
            edits.service.apply(other, f"op-edit-{number:04d}", f"p{number}", relabel(number, key), {key: 0})

    ended = run_concurrently(work)
    assert set(ended) <= {"done", "stale"}
    docs = edits.documents(other)
    assert set(docs) == {"m1", "m2", "m3"}
    adopted = [row for row in edits.service.log(other, 0) if row.name == "adopt"]
    edited = [row for row in edits.service.log(other, 0) if row.name != "adopt"]
    assert len(adopted) + len(edited) == sum(doc.revision for doc in docs.values())
    assert len(edited) == ended["done"] - MANY // 2
