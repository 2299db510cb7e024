"""A corrected track: a sparse document over the engine's boxes, which stay in evidence.

The state of a track at frame f, with K the last key frame at or before f:

1. the track is deleted, or K is outside: nothing;
2. f is a key frame with a box: that box;
3. K interpolates and a later key frame has a box: the straight line between them;
4. a segment holds f: the engine's box of that track and frame;
5. otherwise nothing.

``occluded`` is K's. The label is that of the key frame at f, else the document's, else the engine's.
``NO_CLASS`` is a label like any other. An attribute is K's, else the document's.

Empty fields (no attributes, nothing to ignore) are omitted when a document is stored or sent, so documents of older
versions, which lack them, stay unchanged.
"""

from __future__ import annotations

from itertools import takewhile, zip_longest
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, StrictBool, ValidationError, ValidatorFunctionWrapHandler, WrapValidator

from app.body_model import PLAIN, Model
from tsr_engine.json_shapes import JsonObject
from tsr_engine.track_table import NO_CLASS

OPEN_END = 2**31 - 2
"""Last frame of a segment that may still grow, because its run is not complete."""
_MAX_COORDINATE = 1e5


def _check_box(box: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    x1, y1, x2, y2 = box
    if not (x1 < x2 and y1 < y2):
        raise ValueError("a box is x1, y1, x2, y2 with x1 < x2 and y1 < y2")
    if max(abs(value) for value in box) > _MAX_COORDINATE:
        raise ValueError(f"the edges of a box lie within {_MAX_COORDINATE:.0f} px")
    return box


_Edge = Annotated[float, Field(strict=True)]
Box = Annotated[tuple[_Edge, _Edge, _Edge, _Edge], AfterValidator(_check_box)]
"""x1, y1, x2, y2; 0-based pixel edges."""
Frame = Annotated[int, Field(ge=0, le=2**31 - 2, strict=True)]
ClassId = Annotated[int, Field(ge=NO_CLASS, le=2**31 - 1, strict=True)]
"""Id of a label of the video's set, or ``NO_CLASS``: none of them. Null: the engine's label applies."""
AttributeName = Annotated[str, Field(min_length=1, max_length=200, pattern=PLAIN)]


def _check_value(value: object, handler: ValidatorFunctionWrapHandler) -> object:
    try:
        return handler(value)
    except ValidationError:
        raise ValueError(
            "a value is true or false, a finite number, or a text of at most 1000 characters without NUL"
        ) from None


AttributeValue = Annotated[
    StrictBool
    | Annotated[float, Field(strict=True)]
    | Annotated[str, Field(strict=True, max_length=1000, pattern=PLAIN)],
    WrapValidator(_check_value),
]
"""Of a checkbox, of a number, of a select or a text."""
Attributes = dict[AttributeName, AttributeValue]
"""Name of an attribute -> its value."""


def _is_empty(value: object) -> bool:
    return not value


Key = Annotated[str, Field(pattern=r"^(m[0-9]{1,12}|h[0-9a-z]{6,40})$")]
"""``m7``: the engine's track 7; ``h...``: made by a person."""
Review = Literal["open", "accepted", "rejected", "needs_work"]


class Segment(Model):
    """A part of an engine track."""

    track: Annotated[int, Field(ge=0, le=10**12, strict=True)]
    first: Frame
    last: Frame
    """Inclusive."""


class KeyFrame(Model):
    """A person's values for one frame and the frames up to the next key frame."""

    box: Box | None = None
    """Null: the box is the engine's."""
    occluded: bool = False
    """From here to the next key frame."""
    outside: bool = False
    """No box from here to the next key frame."""
    interpolate: bool = False
    """Straight line from here to the next key frame with a box."""
    class_id: ClassId | None = None
    """Label of this box only; null: the track's; -1: none of the classes."""
    followed: bool = False
    """The box was followed from a person's boxes in other frames; a new follow may replace it."""
    attributes: Attributes = Field(default_factory=dict, max_length=200, exclude_if=_is_empty)
    """Attributes that differ from the track's in these frames."""

    def state(self) -> JsonObject:
        """The fields that also apply to the frames up to the next key frame."""
        state = {"occluded": self.occluded, "outside": self.outside, "interpolate": self.interpolate}
        return {**state, "attributes": self.attributes}


class Note(Model):
    """A remark pinned to a frame."""

    id: Annotated[str, Field(min_length=1, max_length=64)]
    frame: Frame
    text: Annotated[str, Field(min_length=1, max_length=4000)]
    author: str
    time: str


class TrackDoc(Model):
    """A person's corrections of one track. An untouched track has no document."""

    key: Key
    """`m7`: the engine's track 7; `h...`: made by a person."""
    revision: int = 0
    """0: untouched."""
    class_id: ClassId | None = None
    """Null: the engine's class applies; -1: a person says that it is none of the classes."""
    review: Review = "open"
    not_a_sign: bool = False
    """How older versions marked a false positive."""
    segments: tuple[Segment, ...] = ()
    """Parts of engine tracks, in order of frames, disjoint."""
    keys: dict[Annotated[str, Field(pattern=r"^[0-9]{1,10}$")], KeyFrame] = Field(default_factory=dict)
    """By ordinal."""
    notes: tuple[Note, ...] = ()
    gone: bool = False
    """Deleted, or merged into another."""
    merged_into: Key | None = None
    attributes: Attributes = Field(default_factory=dict, max_length=200, exclude_if=_is_empty)
    """Attributes of the whole track; those of key frames have precedence."""
    ignore: Annotated[bool, Field(exclude_if=_is_empty)] = False
    """A region to ignore: exports mark it if their format can, and training does not use it."""

    def frames(self) -> list[int]:
        """Key frames in order."""
        return sorted(int(k) for k in self.keys)

    def last_key(self, frame: int) -> int | None:
        """Return the last key frame at or before a frame."""
        return max((k for k in map(int, self.keys) if k <= frame), default=None)

    def next_key(self, frame: int) -> int | None:
        """Return the first key frame after a frame."""
        return min((k for k in map(int, self.keys) if k > frame), default=None)

    def line_at(self, frame: int) -> tuple[float, float, float, float] | None:
        """Return the box that key frames give a frame: a key frame's own box, or an interpolated one; None: neither."""
        before = self.last_key(frame)
        if before is None or self.keys[str(before)].outside:
            return None
        if before == frame and self.keys[str(frame)].box is not None:
            return self.keys[str(frame)].box
        if not self.keys[str(before)].interpolate:
            return None
        start = max((k for k in map(int, self.keys) if k <= frame and self.keys[str(k)].box is not None), default=None)
        end = self.next_key(frame)
        while end is not None and self.keys[str(end)].box is None and not self.keys[str(end)].outside:
            end = self.next_key(end)
        if start is None or end is None or self.keys[str(end)].box is None:
            return None
        a, b = self.keys[str(start)].box, self.keys[str(end)].box
        assert a is not None
        assert b is not None
        share = (frame - start) / (end - start)
        x1, y1, x2, y2 = (p + share * (q - p) for p, q in zip(a, b, strict=True))
        return x1, y1, x2, y2

    def line_ends(self, frame: int) -> dict[int, Box]:
        """Return the boxes that a track needs if it is cut before a frame, by frame: where a line ends and begins then.

        They lie apart from the cut if key frames without a box interrupt the line.
        """
        frames = self.frames()
        earlier = takewhile(lambda k: self.keys[str(k)].box is None, (k for k in reversed(frames) if k < frame))
        later = takewhile(lambda k: self.keys[str(k)].box is None, (k for k in frames if k >= frame))
        found: dict[int, Box] = {}
        for places in ((frame, *later), (frame - 1, *(k - 1 for k in earlier))):
            lines = ((place, self.line_at(place)) for place in places)
            found |= next(({place: line} for place, line in lines if line is not None), {})
        return found

    def with_key(self, frame: int, **changes: object) -> TrackDoc:
        """Return the document with a key frame: the existing one, or else the values carried over, with changes."""
        present = self.keys.get(str(frame))
        if present is None:
            before = self.last_key(frame)
            carried = KeyFrame(interpolate=not self.segments) if before is None else self.keys[str(before)]
            present = KeyFrame(**carried.state())
        return self.model_copy(update={"keys": {**self.keys, str(frame): present.model_copy(update=changes)}})

    def attributes_at(self, frame: int) -> Attributes:
        """The attributes in a frame."""
        before = self.last_key(frame)
        return {**self.attributes, **({} if before is None else self.keys[str(before)].attributes)}

    def shows_from(self, frame: int) -> bool:
        """Whether the track may show a box in a frame or later; a segment may lack single frames."""
        starts = [frame, *(k for k in self.frames() if k > frame)]
        for start, following in zip_longest(starts, starts[1:]):
            last = self.last_key(start)
            if last is not None and self.keys[str(last)].outside:
                continue
            if self.line_at(start) is not None:
                return True
            if any(s.last >= start and (following is None or s.first < following) for s in self.segments):
                return True
        return False

    def last_named_frame(self) -> int | None:
        """Return the last frame with a key frame or note; None: there is none."""
        return max((*map(int, self.keys), *(note.frame for note in self.notes)), default=None)

    def is_no_sign(self) -> bool:
        """Whether a person has deleted the track, or says that it is no sign."""
        return self.gone or self.not_a_sign or self.review == "rejected"

    def engine_tracks(self) -> list[int]:
        """Return the engine's tracks in the document: the one with the same key, then those of the segments."""
        own = [int(self.key[1:])] if self.key.startswith("m") else []
        return [*own, *(segment.track for segment in self.segments)]

    def original_track(self) -> int | None:
        """Return the engine's track whose label applies if people give none; None: there is none."""
        return next(iter(self.engine_tracks()), None)

    def untouched(self, span: tuple[int, int] | None) -> bool:
        """Whether the document holds no corrections, or all of them were undone.

        Args:
            span: first and last frame of the engine's track with this key; None: there is none.
        """
        if self.merged_into is not None or self.class_id is not None or self.review != "open" or self.not_a_sign:
            return False
        if self.keys or self.notes or self.attributes or self.ignore:
            return False
        if not self.key.startswith("m"):
            return self.gone and not self.segments
        if self.gone or span is None or len(self.segments) != 1:
            return False
        (piece,) = self.segments
        return self.key == f"m{piece.track}" and piece.first <= span[0] and span[1] <= piece.last

    def has_same_content(self, other: TrackDoc) -> bool:
        """Whether the documents are equal apart from their revision."""
        return self.model_copy(update={"revision": other.revision}) == other

    def empty(self) -> bool:
        """Whether no frame shows the track."""
        return not self.segments and not any(key.box is not None and not key.outside for key in self.keys.values())


def engine_doc(track: int, first: int, last: int) -> TrackDoc:
    """Return the document of an untouched engine track."""
    return TrackDoc(key=f"m{track}", segments=(Segment(track=track, first=first, last=last),))
