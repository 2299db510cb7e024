"""Whether the tracks of a command still are as the page that sends it knows them."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy.orm import Session

from app.edits.apply import CommandError, apply_command
from app.edits.documents import TrackDoc
from app.edits.history import last_said
from app.errors import Conflict, PreconditionRequired

__all__ = ["check_revisions"]


def check_revisions(
    session: Session,
    run_id: str,
    author: str,
    command: Any,
    present: Mapping[str, TrackDoc],
    keys: Sequence[str],
    expected: Mapping[str, int] | None,
) -> None:
    """Refuse a command that was made for other versions of its tracks.

    Args:
        session: reads the log.
        run_id: the run.
        author: who sends the command.
        command: see :mod:`app.edits.commands`.
        present: documents of the touched tracks that exist.
        keys: of the touched tracks.
        expected: revision of each as the page knows it; unset: none was sent.

    Raises:
        PreconditionRequired: a revision is missing.
        Conflict: a track has changed since; ``details`` holds both versions, and who did what last.
    """
    known = expected or {}
    there = [key for key in keys if key in present]
    missing = [key for key in there if key not in known]
    if missing:
        raise PreconditionRequired(
            f'Say which revision the edit was made for: If-Match: "{missing[0]}:{present[missing[0]].revision}".'
        )
    stale = {key: known[key] for key in there if known[key] != present[key].revision}
    if not stale:
        return
    yours: list[Any] = []
    with contextlib.suppress(CommandError):
        yours = [doc.model_dump(mode="json") for doc in apply_command(present, command).values()]
    raise Conflict(
        f"Track {next(iter(stale))} has been changed since you saw it. Look at both versions and decide.",
        code="stale",
        details={
            "current": [present[key].model_dump(mode="json") for key in stale],
            "yours": yours,
            "by": {key: last.model_dump() for key, last in last_said(session, run_id, author, stale).items()},
        },
    )
