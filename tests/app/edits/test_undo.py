"""Undo targets: reading the log backwards gives the same as reading the whole log forwards."""

from __future__ import annotations

import random
from collections import defaultdict

import pytest
from sqlalchemy import event

from app.edits.undo import targets
from app.storage.models import Edit
from tests.app.edits.edit_services import EditServices


def write(edits: EditServices, rows: list[tuple[str, str, str, str | None]]) -> None:
    with edits.database.write() as session:
        for op, author, kind, reverts in rows:
            row = Edit(op_id=op, run_id=edits.run, author=author, kind=kind, command={}, frame=1, before={}, after={})
            row.reverts = reverts
            session.add(row)
            session.flush()


@pytest.mark.parametrize("seed", range(3))
def test_backward_and_forward_reading_agree(edits: EditServices, seed: int) -> None:
    rng = random.Random(seed)
    done: dict[str, list[str]] = defaultdict(list)
    undone: dict[str, list[str]] = defaultdict(list)
    for step in range(120):
        author, op = rng.choice(["ann", "bob"]), f"op-{seed}-{step:05d}"
        kind, reverts = "set_box", None
        drift = rng.random()
        if drift < 0.35 and done[author]:
            kind, reverts = "undo", done[author].pop()
            undone[author].append(reverts)
        elif drift < 0.6 and undone[author]:
            kind, reverts = "redo", undone[author].pop()
            done[author].append(reverts)
        else:
            done[author].append(op)
            undone[author].clear()
        write(edits, [(op, author, kind, reverts)])
        with edits.database.read() as session:
            for who in ("ann", "bob"):
                undo, redo = targets(session, edits.run, who)
                assert (undo and undo.op_id) == (done[who][-1] if done[who] else None)
                assert (redo and redo.op_id) == (undone[who][-1] if undone[who] else None)


def test_a_long_log_is_not_read_completely(edits: EditServices) -> None:
    write(edits, [(f"op-{k:08d}", "ann", "set_box", None) for k in range(600)])
    rows = []

    @event.listens_for(Edit, "load")
    def loaded(*_: object) -> None:
        rows.append(1)

    statements: list[str] = []
    event.listen(edits.database.engine, "before_cursor_execute", lambda *given: statements.append(given[2]))
    with edits.database.read() as session:
        undo, redo = targets(session, edits.run, "ann")
    event.remove(Edit, "load", loaded)
    assert undo is not None
    assert (undo.op_id, redo) == ("op-00000599", None)
    assert not rows
    assert sum("FROM edits" in statement for statement in statements) == 2
    assert all("LIMIT" in statement or "op_id =" in statement for statement in statements if "FROM edits" in statement)
