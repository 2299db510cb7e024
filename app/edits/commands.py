"""The operations that a person can carry out on tracks, as typed commands."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, StrictBool, field_validator

from app.edits.documents import AttributeName, AttributeValue, Box, ClassId, Frame, Key, Review, Segment
from app.shapes import PLAIN, Model

__all__ = ["MOST_FOLLOWED", "Command", "Redo", "Undo"]

MOST_FOLLOWED = 20_000
"""Most boxes of one ``follow`` command."""


class _OnTrack(Model):
    frame: Frame
    """The frame that the person looks at."""
    key: Key
    spans: Annotated[list[Segment], Field(max_length=60, default_factory=list)]
    """What the page took engine tracks without a document to be; the server asks the evidence instead."""


class _Labels(_OnTrack):
    """A command that gives a label."""

    class_id: ClassId | None = None
    label_key: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    """Key of the label that ``class_id`` is meant to be: the video may use another label set by now."""


class CreateTrack(_Labels):
    """A new track with its first box."""

    name: Literal["create_track"]
    box: Box


class SetBox(_OnTrack):
    """Draw, move or resize: the frame becomes a key frame with this box."""

    name: Literal["set_box"]
    box: Box


class RelabelTrack(_Labels):
    """Label of the whole track; null: the engine's again, -1: none of the classes."""

    name: Literal["relabel_track"]
    class_id: ClassId | None


class RelabelBox(_Labels):
    """Label of the box in this frame alone, null: the track's again; ``box`` is the one on screen."""

    name: Literal["relabel_box"]
    class_id: ClassId | None
    box: Box | None = None


class Merge(_OnTrack):
    """Others become part of the track; where both have a frame, the track's own counts."""

    name: Literal["merge"]
    others: Annotated[list[Key], Field(min_length=1, max_length=50)]


class Split(_OnTrack):
    """From this frame on it is another track.

    ``class_id`` is what the page takes the engine's class of the track to be, for a half without a piece of the
    engine's; the server asks the evidence instead.
    """

    name: Literal["split"]
    new_key: Annotated[str, Field(pattern=r"^h[0-9a-z]{6,40}$")]
    class_id: ClassId | None = None


class DeleteFrom(_OnTrack):
    """Nothing from this frame on."""

    name: Literal["delete_from"]


class DeleteTrack(_OnTrack):
    """Nothing at all."""

    name: Literal["delete_track"]


class RestoreTrack(_OnTrack):
    """A deleted track is there again, as it was."""

    name: Literal["restore_track"]


class AddKey(_OnTrack):
    """Make this frame a key frame with the box on screen."""

    name: Literal["add_key"]
    box: Box


class RemoveKey(_OnTrack):
    """Forget what was said at this frame."""

    name: Literal["remove_key"]


class Interpolate(_OnTrack):
    """Straight lines between the key frames of a range; ``value`` false: the engine's boxes again."""

    name: Literal["interpolate"]
    first: Frame
    last: Frame
    value: StrictBool = True


class FollowedBox(Model):
    """One box of a track that was followed."""

    frame: Frame
    box: Box
    anchor: StrictBool = False
    """A person has put the box here; all others were followed from such boxes."""


class Follow(_OnTrack):
    """The boxes between the first and the last frame given lie on lines between these; one of them is an anchor."""

    name: Literal["follow"]
    boxes: Annotated[list[FollowedBox], Field(min_length=1, max_length=MOST_FOLLOWED)]

    @field_validator("boxes")
    @classmethod
    def _in_order(cls, boxes: list[FollowedBox]) -> list[FollowedBox]:
        if any(a.frame >= b.frame for a, b in pairwise(boxes)):
            raise ValueError("the boxes must be in order of frames, one a frame")
        if not any(box.anchor for box in boxes):
            raise ValueError("one of the boxes must be an anchor")
        return boxes


class SetOccluded(_OnTrack):
    """Hidden (or not) from here to the next key frame; ``box`` is the one on screen."""

    name: Literal["set_occluded"]
    value: StrictBool
    box: Box | None = None


class SetOutside(_OnTrack):
    """Out of sight (or back) from here to the next key frame; ``box`` is the one on screen."""

    name: Literal["set_outside"]
    value: StrictBool
    box: Box | None = None


class SetNotASign(_OnTrack):
    """What was tracked is no traffic sign."""

    name: Literal["set_not_a_sign"]
    value: StrictBool


class SetIgnore(_OnTrack):
    """The track is a region that nobody counts: it may be a sign, and no training learns from it."""

    name: Literal["ignore"]
    value: StrictBool


class SetAttribute(_OnTrack):
    """An attribute of the whole track, or from this frame on until it changes the next time.

    ``value`` null takes it away: from the whole track, or from this frame on, where the track's own counts then.
    ``box`` is the one on screen.
    """

    name: Literal["attribute"]
    attribute: AttributeName
    value: AttributeValue | None
    from_here: StrictBool = False
    box: Box | None = None


class SetReview(_OnTrack):
    """The verdict on the track."""

    name: Literal["set_review"]
    review: Review


class ReviewTracks(_OnTrack):
    """The same verdict on the track and on others: one operation, so that one undo takes it back."""

    name: Literal["review_tracks"]
    others: Annotated[list[Key], Field(max_length=499)]
    review: Review


class AddNote(_OnTrack):
    """A remark pinned to this frame."""

    name: Literal["add_note"]
    note_id: Annotated[str, Field(min_length=1, max_length=64, pattern=PLAIN)]
    text: Annotated[str, Field(min_length=1, max_length=4000, pattern=PLAIN)]


class EditNote(_OnTrack):
    """Another text."""

    name: Literal["edit_note"]
    note_id: Annotated[str, Field(min_length=1, max_length=64, pattern=PLAIN)]
    text: Annotated[str, Field(min_length=1, max_length=4000, pattern=PLAIN)]


class RemoveNote(_OnTrack):
    """Away with it."""

    name: Literal["remove_note"]
    note_id: Annotated[str, Field(min_length=1, max_length=64, pattern=PLAIN)]


class Undo(Model):
    """Take an operation back."""

    name: Literal["undo"]
    op_id: Annotated[str, Field(pattern=r"^[0-9A-Za-z-]{8,64}$")]


class Redo(Model):
    """Carry out again what was taken back."""

    name: Literal["redo"]
    op_id: Annotated[str, Field(pattern=r"^[0-9A-Za-z-]{8,64}$")]


Command = Annotated[
    CreateTrack
    | SetBox
    | RelabelTrack
    | RelabelBox
    | Merge
    | Split
    | DeleteFrom
    | DeleteTrack
    | RestoreTrack
    | AddKey
    | RemoveKey
    | Interpolate
    | Follow
    | SetOccluded
    | SetOutside
    | SetNotASign
    | SetIgnore
    | SetAttribute
    | SetReview
    | ReviewTracks
    | AddNote
    | EditNote
    | RemoveNote,
    Field(discriminator="name"),
]
"""One operation; ``name`` says which."""
