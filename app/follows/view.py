"""The view of a follow for pages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

from app.body_model import Model
from app.edits.documents import Box, Frame
from app.storage.models import Follow

Only = Literal["forward", "backward", "between"]
"""One direction only, or only the frames between the outermost anchors."""

FollowState = Literal["queued", "running", "complete", "failed", "cancelled"]
ProposalSource = Literal["anchor", "detected", "matched", "predicted"]


class FollowAnchor(Model):
    """A box that a person has set."""

    frame: Frame
    box: Box


class FollowEnding(Model):
    """Why following stopped in one direction; proposals beyond ``frame`` are withdrawn."""

    direction: Literal["backward", "forward"]
    frame: int
    reason: str
    sentence: str


class FollowView(Model):
    """A sign that the server follows. Its proposals are no data until a person accepts them."""

    id: str
    run_id: str
    key: str
    """The track."""
    anchors: list[FollowAnchor]
    only: Only | None
    first: int
    last: int | None
    state: FollowState
    error: str | None
    note: str
    """What a worker does for it besides its progress, in a few words; empty: nothing to say."""
    proposals: list[tuple[int, float, float, float, float, float, ProposalSource]]
    """frame, x1, y1, x2, y2, confidence, source; a later proposal for a frame replaces the earlier one."""
    endings: list[FollowEnding]
    next: int
    """Request the proposals after this number next time."""


def follow_view(follow: Follow, pieces: Iterable[Sequence[Sequence[object]]], following: int) -> FollowView:
    """Build the view of a follow with some of its proposals."""
    return FollowView.from_row(
        follow,
        anchors=follow.request["anchors"],
        only=follow.request["only"],
        first=follow.request["first"],
        last=follow.request["last"],
        proposals=[tuple(row) for piece in pieces for row in piece],
        note=follow.note if follow.state in ("queued", "running") else "",
        next=following,
    )
