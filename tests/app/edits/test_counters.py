"""The sums that each edit updates equal those that the migration computes from the documents and the whole log."""

from __future__ import annotations

import random
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from pydantic import TypeAdapter
from sqlalchemy import delete, select

from app.edits.commands import Command, Redo, SetReview, Undo
from app.edits.counters import add_to_totals
from app.errors import Conflict, Invalid
from app.storage.migrations.versions.v0013_sums import fill
from app.storage.models import Edit, ReviewCount, Verdict, WorkDay
from tests.app.edits.edit_services import EditServices
from tests.app.edits.random_commands import random_command

ADAPTER: TypeAdapter[Any] = TypeAdapter(Command)
START = datetime(2026, 1, 1, 12, tzinfo=UTC)


def stored_counters(edits: EditServices) -> dict[str, Any]:
    with edits.database.read() as session:
        counts = session.scalars(select(ReviewCount)).all()
        verdicts = session.scalars(select(Verdict)).all()
        days = session.scalars(select(WorkDay)).all()
        return {
            "counts": [(row.run_id, row.more, row.reviewed) for row in counts],
            "verdicts": {(row.author, row.key): (row.verdict, row.day) for row in verdicts},
            "days": {
                (row.author, row.day): (round(row.seconds, 3), row.seq, row.last, row.latest, round(row.back, 3))
                for row in days
            },
        }


def recomputed_counters(edits: EditServices) -> dict[str, Any]:
    with edits.database.write() as session:
        fill(session.connection())
    return stored_counters(edits)


@pytest.mark.parametrize("seed", range(2))
def test_sums_equal_those_of_the_whole_log(edits: EditServices, seed: int) -> None:
    rng = random.Random(seed)
    for step in range(60):
        docs = edits.documents()
        author = rng.choice(["ann", "bob"])
        seen = edits.service.annotation(edits.run, author)
        keys = ["m1", "m2", "m3", *(key for key in docs if key.startswith("h"))]
        revisions = {key: docs[key].revision if key in docs else 0 for key in [*keys, "m9"]}
        review = rng.choice(["accepted", "accepted", "rejected", "open"])
        command: Any = ADAPTER.validate_python(
            rng.choice(
                [
                    {"name": "set_review", "frame": 3, "key": rng.choice(keys), "review": review},
                    {"name": "review_tracks", "frame": 3, "key": "m1", "others": keys[1:], "review": review},
                    random_command(rng, docs, step),
                ]
            )
        )
        drift = rng.random()
        if drift < 0.25 and seen.undo is not None:
            command = Undo(name="undo", op_id=seen.undo.op_id)
        elif drift < 0.4 and seen.redo is not None:
            command = Redo(name="redo", op_id=seen.redo.op_id)
        op = f"op-{seed}-{step:06d}"
        try:
            if drift > 0.85:
                edits.bulk.apply_to_tracks(edits.run, op, author, "edit_tracks", lambda key: [_judging(key)], revisions)
            else:
                edits.service.apply(edits.run, op, author, command, revisions)
        except (Conflict, Invalid):
            continue
    kept = stored_counters(edits)
    assert len(kept["verdicts"]) > 3
    assert kept["counts"][0][2] > 0
    assert kept == recomputed_counters(edits)


def _judging(key: str) -> SetReview:
    return SetReview(name="set_review", frame=0, key=key, spans=[], review="rejected")


def test_undoing_a_verdict_restores_the_previous_one(edits: EditServices) -> None:
    def said() -> dict[tuple[str, str], str]:
        return {whose: verdict for whose, (verdict, _) in stored_counters(edits)["verdicts"].items()}

    def judge(op: str, revision: int, review: str) -> None:
        command = ADAPTER.validate_python({"name": "set_review", "frame": 1, "key": "m1", "review": review})
        edits.service.apply(edits.run, f"op-{op:0>8}", "ann", command, {"m1": revision})

    judge("1", 0, "accepted")
    judge("2", 1, "rejected")
    assert said() == {("ann", "m1"): "rejected"}
    edits.service.apply(edits.run, "op-undo-01", "ann", Undo(name="undo", op_id="op-00000002"), None)
    assert said() == {("ann", "m1"): "accepted"}
    edits.service.apply(edits.run, "op-undo-02", "ann", Undo(name="undo", op_id="op-00000001"), None)
    assert said() == {}
    assert stored_counters(edits)["counts"] == [(edits.run, 0, 0)]
    edits.service.apply(edits.run, "op-redo-01", "ann", Redo(name="redo", op_id="op-00000001"), None)
    assert said() == {("ann", "m1"): "accepted"}
    assert stored_counters(edits)["counts"] == [(edits.run, 0, 1)]


def add_work(edits: EditServices, author: str, *moments: datetime) -> None:
    """Log an operation of a person at each of these times."""
    with edits.database.write() as session:
        for moment in moments:
            row = Edit(op_id=f"{author}{moment.timestamp()}", run_id=edits.run, author=author, kind="add_note")
            row.command, row.before, row.after, row.created = {"name": "add_note"}, {}, {}, moment
            session.add(row)
            session.flush()
            add_to_totals(session, row)


def test_working_hours_ignore_pauses_and_clock_changes(edits: EditServices) -> None:
    def work(author: str, *minutes: float) -> None:
        add_work(edits, author, *(START + timedelta(minutes=each) for each in minutes))

    work("steady", 0, 3, 6)
    work("night", 7, 607)  # counts as a break; five minutes after midnight it is another day
    work("late", 720, 725)
    work("back", 800, 60, 61)  # a backward step as zero
    days = stored_counters(edits)["days"]
    seconds = {whose: day[0] for whose, day in days.items()}
    first = (START - datetime(1970, 1, 1, tzinfo=UTC)).days
    assert seconds == {
        ("steady", first): 360,
        ("night", first): 300,
        ("late", first + 1): 300,
        ("back", first + 1): 0,
        ("back", first): 60,
    }
    assert {whose: day[4] for whose, day in days.items() if day[4]} == {("back", first): 740 * 60}
    assert recomputed_counters(edits)["days"] == days


def test_working_hours_go_on_after_a_run_was_removed(edits: EditServices) -> None:
    def work(author: str, day: int, seconds: range) -> None:
        add_work(edits, author, *(START + timedelta(days=day, seconds=second) for second in seconds))

    work("ann", 0, range(5))
    work("ann", 1, range(5))
    with edits.database.write() as session:
        session.execute(delete(Edit))  # SQLite gives the numbers again
    work("ann", 2, range(7))
    work("bob", 2, range(3))  # takes the numbers of the removed edits
    work("ann", 2, range(7, 20))
    seconds = [day[0] for whose, day in sorted(stored_counters(edits)["days"].items()) if whose[0] == "ann"]
    assert seconds == [4, 300 + 4, 300 + 19], "the first operation of each further day ends a pause"
