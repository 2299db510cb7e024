"""Actions on found tracks: judge, relabel or ignore them, with one operation in each run."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from typing import Annotated, Literal
from uuid import uuid4

from pydantic import Field
from sqlalchemy import select

from app.body_model import PLAIN, Model
from app.edits.bulk import BulkEdits
from app.edits.commands import Command, RelabelTrack, SetIgnore, SetNotASign, SetReview, Undo
from app.edits.documents import Key, Review
from app.edits.service import EditService
from app.errors import ApiError, Invalid
from app.labels.store import labels_of_video
from app.search.filters import named_labels
from app.search.index import SearchIndex
from app.search.query import FoundTrack, found_tracks
from app.storage.database import Database
from app.storage.models import Run, Video

MAX_TRACKS = 5000
"""Maximum number of tracks of one action."""
OPERATION = "edit_tracks"
"""Kind of the operation in the log."""
_INDEX_WAIT_S = 2.0
"""Seconds that a response waits for the tables of the search."""
_MAX_SENTENCES = 200

RunName = Annotated[str, Field(pattern="^[0-9a-f]{32}$")]
_OpId = Annotated[str, Field(pattern=r"^[0-9A-Za-z-]{8,64}$")]


class Judge(Model):
    """Set a verdict."""

    type: Literal["judge"]
    review: Review


class Ignore(Model):
    """Mark the tracks as regions to ignore, or remove that mark."""

    type: Literal["ignore"]
    value: bool


class Relabel(Model):
    """Set a label by key, name or alias; each video has its own set."""

    type: Literal["relabel"]
    label: Annotated[str, Field(min_length=1, max_length=200, pattern=PLAIN)]


TrackAction = Annotated[Judge | Ignore | Relabel, Field(discriminator="type")]


class WantedTrack(Model):
    """A track in the revision that the person has seen."""

    run: RunName
    key: Key
    revision: Annotated[int, Field(ge=0, le=2**31 - 1)]


class Operation(Model):
    """An action's operation in the log of one run."""

    run: RunName
    op_id: _OpId


class TracksDone(Model):
    """Result of an action."""

    changed: int
    operations: list[Operation]
    """Operations, for an undo."""
    stayed: int
    sentences: list[str]
    """The first tracks that were not changed, with reasons."""
    tracks: list[FoundTrack]
    """Current state of the changed tracks, without those that are deleted or not in the tables yet."""


class SearchActions:
    """Changes found tracks."""

    def __init__(self, database: Database, edits: EditService, bulk: BulkEdits, index: SearchIndex) -> None:
        self._database = database
        self._edits = edits
        self._bulk = bulk
        self._index = index

    def apply(self, action: TrackAction, tracks: Sequence[WantedTrack], author: str, action_id: str) -> TracksDone:
        """Apply an action.

        Args:
            action: the action.
            tracks: the tracks.
            author: author of the operations.
            action_id: chosen by the page; a repeated action is applied once.

        Raises:
            Invalid: none of the videos' sets has such a label.
        """
        revisions_by_run: dict[str, dict[str, int]] = {}
        for track in tracks:
            revisions_by_run.setdefault(track.run, {})[track.key] = track.revision
        makers = self._command_makers(action, list(revisions_by_run))
        operations: list[Operation] = []
        changed: list[tuple[str, str]] = []
        stayed: list[tuple[str, str, str]] = []
        for run, expected in revisions_by_run.items():
            make = makers.get(run, lambda _: [])  # a missing run: applying the operation reports it
            op_id = hashlib.blake2b(f"{action_id} {run}".encode(), digest_size=16).hexdigest()
            if isinstance(make, str):
                stayed += [(run, key, make) for key in expected]
                continue
            try:
                done = self._bulk.apply_to_tracks(run, op_id, author, OPERATION, make, expected)
            except ApiError as error:  # the file, server or run of one drive does not affect the others
                stayed += [(run, key, error.message.rstrip(".")) for key in expected]
                continue
            changed += [(run, key) for key in done.changed]
            stayed += [(run, key, reason) for key, reason in done.stayed.items()]
            if done.changed:
                operations.append(Operation(run=run, op_id=op_id))
        return self._done(operations, changed, stayed)

    def undo(self, operations: Sequence[Operation], author: str) -> TracksDone:
        """Undo the operations of an action, except where others have changed the tracks since."""
        undone: list[Operation] = []
        changed: list[tuple[str, str]] = []
        stayed: list[tuple[str, str, str]] = []
        for operation in operations:
            try:
                answer = self._edits.apply(
                    operation.run, uuid4().hex, author, Undo(name="undo", op_id=operation.op_id), None
                )
            except ApiError as error:
                stayed.append((operation.run, "", error.message.rstrip(".")))
                continue
            undone.append(operation)
            changed += [(operation.run, doc.key) for doc in answer.docs]
        return self._done(undone, changed, stayed)

    def _command_makers(
        self, action: TrackAction, runs: Sequence[str]
    ) -> dict[str, Callable[[str], list[Command]] | str]:
        """For each run the function that makes the commands of a track, or the reason why its tracks stay."""
        if isinstance(action, Judge):
            return dict.fromkeys(runs, lambda key: _verdict(key, action.review))
        if isinstance(action, Ignore):
            return dict.fromkeys(
                runs, lambda key: [SetIgnore(name="ignore", frame=0, key=key, spans=[], value=action.value)]
            )
        found: dict[str, Callable[[str], list[Command]] | str] = {}
        with self._database.read() as session:
            for run_id in runs:
                run = session.get(Run, run_id)
                if run is None:
                    continue
                labels = labels_of_video(session, run.video_id)
                exact = labels.by_key(action.label)
                named = named_labels(labels, action.label) if exact is None else [exact]
                if len(named) == 1:
                    found[run_id] = _relabeller(labels.resolved(named[0].id))
                elif named:
                    several = ", ".join(f"'{label.name}'" for label in named)
                    found[run_id] = f"'{action.label}' may be {several}: name one of them"
                else:
                    found[run_id] = f"the label set '{labels.name}' has no label '{action.label}'"
        if found and all(isinstance(make, str) for make in found.values()):
            reason = next(make for make in found.values() if isinstance(make, str))
            raise Invalid(f"{reason[0].upper()}{reason[1:]}.", field="action.label", code="no_such_label")
        return found

    def _done(
        self, operations: list[Operation], changed: Sequence[tuple[str, str]], stayed: Sequence[tuple[str, str, str]]
    ) -> TracksDone:
        self._index.update(_INDEX_WAIT_S)
        with self._database.read() as session:
            runs = sorted({run for run, _, _ in stayed[:_MAX_SENTENCES]})
            query = select(Run.id, Video.name).join(Video, Video.id == Run.video_id).where(Run.id.in_(runs))
            names = {row[0]: row[1] for row in session.execute(query)}
            tracks = found_tracks(session, changed)
        sentences = []
        for run, key, reason in stayed[:_MAX_SENTENCES]:
            video_name = names.get(run, "A run that was removed")
            sentences.append(
                f"{video_name}, track {key.removeprefix('m')}: {reason}." if key else f"{video_name}: {reason}."
            )
        return TracksDone(
            changed=len(changed), operations=operations, stayed=len(stayed), sentences=sentences, tracks=tracks
        )


def _verdict(key: str, review: Review) -> list[Command]:
    """Commands for a verdict; other verdicts than rejected also remove an older version's mark that it is no sign."""
    set_review = SetReview(name="set_review", frame=0, key=key, spans=[], review=review)
    unmarked = SetNotASign(name="set_not_a_sign", frame=0, key=key, spans=[], value=False)
    return [set_review] if review == "rejected" else [unmarked, set_review]


def _relabeller(label: int) -> Callable[[str], list[Command]]:
    return lambda key: [RelabelTrack(name="relabel_track", frame=0, key=key, spans=[], class_id=label)]
