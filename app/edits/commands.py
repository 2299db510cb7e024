"""The operations that a person can carry out on tracks, as typed commands."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, StrictBool, field_validator

from app.body_model import PLAIN, Model
from app.edits.documents import AttributeName, AttributeValue, Box, ClassId, Frame, Key, Review, Segment

MAX_FOLLOWED_BOXES = 20_000
"""Most boxes of one ``follow`` command."""
MAX_GAPS = 1000
"""Most gaps that a page may send with a ``merge``."""


class _OnTrack(Model):
    frame: Frame
    """The current frame of the page."""
    key: Key
    spans: Annotated[list[Segment], Field(max_length=60, default_factory=list)]
    """The page's spans of engine tracks without a document; the server reads them from the evidence instead."""


class _Labels(_OnTrack):
    """A command that sets a label."""

    class_id: ClassId | None = None
    label_key: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    """Key of the label ``class_id``, because the video may use another label set by now."""


class CreateTrack(_Labels):
    """Add a track with its first box."""

    name: Literal["create_track"]
    box: Box


class SetBox(_OnTrack):
    """Draw, move or resize a box: the frame becomes a key frame with this box."""

    name: Literal["set_box"]
    box: Box


class RelabelTrack(_Labels):
    """Set the label of the whole track; null: the engine's label again, -1: none of the classes."""

    name: Literal["relabel_track"]
    class_id: ClassId | None


class RelabelBox(_Labels):
    """Set the label of the box in this frame only; null: the track's label again. ``box`` is the displayed box."""

    name: Literal["relabel_box"]
    class_id: ClassId | None
    box: Box | None = None


class Merge(_OnTrack):
    """Merge other tracks into the track; in frames of both, the track's own box is kept.

    ``class_id`` is the engine's class of the track according to the page, for a track that would get the label of
    another one. ``gaps`` are the frames after their start in which the engine's tracks have no box. The server reads
    both from the evidence instead.
    """

    name: Literal["merge"]
    others: Annotated[list[Key], Field(min_length=1, max_length=50)]
    class_id: ClassId | None = None
    gaps: Annotated[list[Segment], Field(max_length=MAX_GAPS, default_factory=list)]


class Split(_OnTrack):
    """Split the track: from this frame on it is another track.

    ``class_id`` is the engine's class of the track according to the page, for a half that would get no label or that of
    another track; the server reads it from the evidence instead.
    """

    name: Literal["split"]
    new_key: Annotated[str, Field(pattern=r"^h[0-9a-z]{6,40}$")]
    class_id: ClassId | None = None


class DeleteFrom(_OnTrack):
    """Delete the track from this frame on."""

    name: Literal["delete_from"]


class DeleteTrack(_OnTrack):
    """Delete the whole track."""

    name: Literal["delete_track"]


class RestoreTrack(_OnTrack):
    """Restore a deleted track."""

    name: Literal["restore_track"]


class AddKey(_OnTrack):
    """Make this frame a key frame with the displayed box."""

    name: Literal["add_key"]
    box: Box


class RemoveKey(_OnTrack):
    """Remove the key frame at this frame."""

    name: Literal["remove_key"]


class Interpolate(_OnTrack):
    """Interpolate linearly between the key frames of a range; ``value`` false: show the engine's boxes again."""

    name: Literal["interpolate"]
    first: Frame
    last: Frame
    value: StrictBool = True


class FollowedBox(Model):
    """One box of a followed track."""

    frame: Frame
    box: Box
    anchor: StrictBool = False
    """A person has set this box; the other boxes are followed from such boxes."""


class Follow(_OnTrack):
    """Set followed boxes; frames between them are interpolated, and at least one of the boxes is an anchor."""

    name: Literal["follow"]
    boxes: Annotated[list[FollowedBox], Field(min_length=1, max_length=MAX_FOLLOWED_BOXES)]

    @field_validator("boxes")
    @classmethod
    def _in_order(cls, boxes: list[FollowedBox]) -> list[FollowedBox]:
        if any(a.frame >= b.frame for a, b in pairwise(boxes)):
            raise ValueError("the boxes must be in order of frames, one per frame")
        if not any(box.anchor for box in boxes):
            raise ValueError("one of the boxes must be an anchor")
        return boxes


class SetOccluded(_OnTrack):
    """Mark as occluded (or not) from here to the next key frame; ``box`` is the displayed box."""

    name: Literal["set_occluded"]
    value: StrictBool
    box: Box | None = None


class SetOutside(_OnTrack):
    """Mark as out of view (or back) from here to the next key frame; ``box`` is the displayed box."""

    name: Literal["set_outside"]
    value: StrictBool
    box: Box | None = None


class SetNotASign(_OnTrack):
    """Mark that the track is no traffic sign."""

    name: Literal["set_not_a_sign"]
    value: StrictBool


class SetIgnore(_OnTrack):
    """Mark the track as a region to ignore: it may be a sign, is not counted, and training does not use it."""

    name: Literal["ignore"]
    value: StrictBool


class SetAttribute(_OnTrack):
    """Set an attribute of the whole track, or from this frame on until its next change.

    ``value`` null removes it: from the whole track, or from this frame on, where the track's value then applies.
    ``box`` is the displayed box.
    """

    name: Literal["attribute"]
    attribute: AttributeName
    value: AttributeValue | None
    from_here: StrictBool = False
    box: Box | None = None


class SetReview(_OnTrack):
    """Set the verdict on the track."""

    name: Literal["set_review"]
    review: Review


class ReviewTracks(_OnTrack):
    """Set the same verdict on the track and on others, in one operation that one undo reverts."""

    name: Literal["review_tracks"]
    others: Annotated[list[Key], Field(max_length=499)]
    review: Review


class AddNote(_OnTrack):
    """Add a note to this frame."""

    name: Literal["add_note"]
    note_id: Annotated[str, Field(min_length=1, max_length=64, pattern=PLAIN)]
    text: Annotated[str, Field(min_length=1, max_length=4000, pattern=PLAIN)]


class EditNote(_OnTrack):
    """Another text."""

    name: Literal["edit_note"]
    note_id: Annotated[str, Field(min_length=1, max_length=64, pattern=PLAIN)]
    text: Annotated[str, Field(min_length=1, max_length=4000, pattern=PLAIN)]


class RemoveNote(_OnTrack):
    """Remove a note."""

    name: Literal["remove_note"]
    note_id: Annotated[str, Field(min_length=1, max_length=64, pattern=PLAIN)]


class Undo(Model):
    """Undo an operation."""

    name: Literal["undo"]
    op_id: Annotated[str, Field(pattern=r"^[0-9A-Za-z-]{8,64}$")]


class Redo(Model):
    """Redo an operation that was undone."""

    name: Literal["redo"]
    op_id: Annotated[str, Field(pattern=r"^[0-9A-Za-z-]{8,64}$")]


Command = Annotated[
    CreateTrack | SetBox | RelabelTrack | RelabelBox | Merge | Split | DeleteFrom | DeleteTrack | RestoreTrack
    | AddKey | RemoveKey | Interpolate | Follow | SetOccluded | SetOutside | SetNotASign | SetIgnore | SetAttribute
    | SetReview | ReviewTracks | AddNote | EditNote | RemoveNote,
    Field(discriminator="name"),
]  # fmt: skip
"""One command; ``name`` is its kind."""
