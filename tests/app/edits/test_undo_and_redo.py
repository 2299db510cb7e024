"""Undo and redo of edits through the service."""

from __future__ import annotations

import random

import pytest

from app.edits.commands import Redo, Undo
from app.errors import Conflict, Invalid
from tests.app.edits.edit_services import EditServices
from tests.app.edits.random_commands import initial_documents, random_command
from tests.app.edits.sent_edits import content, relabel, send, undo_or_redo


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


def test_undo_is_refused_after_somebody_elses_change(edits: EditServices) -> None:
    send(edits, "1", relabel(3), {"m1": 0})
    send(edits, "2", relabel(4), {"m1": 1}, "bob")
    with pytest.raises(Conflict):
        undo_or_redo(edits, "3", Undo, "op-00000001")
    undo_or_redo(edits, "4", Undo, "op-00000002", "bob")
    undo_or_redo(edits, "5", Undo, "op-00000001")
    assert content(edits) == {}
