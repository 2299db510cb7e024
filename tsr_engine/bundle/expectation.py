"""Reads and checks the ``expectation.json`` of a bundle: the output that a person expects."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from tsr_engine.errors import ImportFormatError
from tsr_engine.labels.classes import class_names_of, default_keys
from tsr_engine.labels.model import MAX_LABELS, Key

_MAX_COORDINATE = 1e5
_Edge = Annotated[float, Field(ge=-_MAX_COORDINATE, le=_MAX_COORDINATE)]
_Frame = Annotated[int, Field(ge=0, le=2**31 - 1)]
_Name = Annotated[str, Field(min_length=1, max_length=80, pattern=r"^[^\x00-\x1f\x7f]+$")]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Bounds(_Part):
    """Tolerances."""

    iou: Annotated[float, Field(gt=0, le=1)] = 0.5
    """Least IoU at which a result lies on a sign."""
    share: Annotated[float, Field(gt=0, le=1)] = 0.5
    """Share of a sign's frames in which a result must lie on it."""
    eq7: Annotated[float, Field(ge=0, lt=1)] = 0.25
    """Largest Eq. 7 of a box, in [0, 1)."""


class ExpectedSign(_Part):
    """A sign that a person sees, or an object that was mistaken for one."""

    frames: Annotated[list[_Frame], Field(min_length=1)]
    """Frame numbers of the original video, ascending."""
    boxes: list[tuple[_Edge, _Edge, _Edge, _Edge]]
    """``x1, y1, x2, y2`` in each of the frames, px."""
    hidden: list[_Frame] = []
    """Frames in which it is hidden; they are not judged."""

    @model_validator(mode="after")
    def _check(self) -> ExpectedSign:
        if len(self.boxes) != len(self.frames):
            raise ValueError(f"{len(self.frames)} frames have {len(self.boxes)} boxes")
        if any(b <= a for a, b in zip(self.frames, self.frames[1:], strict=False)):
            raise ValueError("the frames are not ascending")
        for frame, (x1, y1, x2, y2) in zip(self.frames, self.boxes, strict=True):
            if not (x1 < x2 and y1 < y2) or not all(map(math.isfinite, (x1, y1, x2, y2))):
                raise ValueError(f"the box of frame {frame} is not x1, y1, x2, y2 with x1 < x2 and y1 < y2")
        return self

    def visible_boxes(self) -> list[tuple[int, tuple[float, float, float, float]]]:
        """Frames and boxes in which it is visible."""
        hidden = set(self.hidden)
        return [(f, box) for f, box in zip(self.frames, self.boxes, strict=True) if f not in hidden]


class Expected(_Part):
    """One expected result.

    * ``found``: a track lies on the sign in at least ``share`` of its frames;
    * ``label``: the track that lies on the sign in the most frames has this class at the end of the frames;
    * ``boxes``: in each of ``frames`` a result has an error of at most ``eq7`` against the sign's box;
    * ``absent``: no track lies on it in any of its frames;
    * ``one``: exactly one track lies on the sign, whatever the frame;
    * ``apart``: no track lies on this sign and on ``other``.
    """

    id: _Name
    kind: Literal["found", "label", "boxes", "absent", "one", "apart"]
    sign: _Name
    class_id: Annotated[int, Field(ge=0, lt=MAX_LABELS)] | None = None
    """For ``label``: class number of the model."""
    frames: list[_Frame] = []
    """For ``boxes``."""
    other: _Name | None = None
    """For ``apart``."""

    @model_validator(mode="after")
    def _check(self) -> Expected:
        if (self.kind == "label") != (self.class_id is not None):
            raise ValueError(f"{self.id}: class_id belongs to kind label, and to no other")
        if (self.kind == "boxes") != bool(self.frames):
            raise ValueError(f"{self.id}: frames belong to kind boxes, and to no other")
        if (self.kind == "apart") != (self.other is not None):
            raise ValueError(f"{self.id}: other belongs to kind apart, and to no other")
        return self


class Expectation(_Part):
    """All expected results."""

    format: Literal[1] = 1
    bounds: Bounds = Bounds()
    signs: dict[_Name, ExpectedSign] = {}
    expected: list[Expected] = []
    labels: Annotated[list[Key], Field(max_length=MAX_LABELS, exclude_if=lambda labels: not labels)] = []
    """Keys of the model's classes by number; empty: those of ``gtsrb-43``."""

    def class_name(self, class_id: int | None) -> str:
        """Number and name of one of the model's classes."""
        names = class_names_of(self.labels or None)
        if class_id is None or not 0 <= class_id < len(names):
            return "nothing known"
        return f"{class_id} ({names[class_id]})"

    @model_validator(mode="after")
    def _check(self) -> Expectation:
        for expected in self.expected:
            if expected.class_id is not None and expected.class_id >= len(self.labels or default_keys()):
                raise ValueError(f"{expected.id}: class_id {expected.class_id} is none of the model's classes")
        names = [expected.id for expected in self.expected]
        if len(set(names)) != len(names):
            raise ValueError("two expectations have the same id")
        for expected in self.expected:
            for name in (expected.sign, expected.other):
                if name is not None and name not in self.signs:
                    raise ValueError(f"{expected.id}: there is no sign {name!r}")
            unknown_frames = set(expected.frames) - set(self.signs[expected.sign].frames)
            if unknown_frames:
                raise ValueError(f"{expected.id}: its sign has no box in frame {min(unknown_frames)}")
        return self

    def text(self) -> str:
        """The JSON text that is stored."""
        return json.dumps(self.model_dump(mode="json"), indent=1, sort_keys=True) + "\n"

    def span(self) -> tuple[int, int] | None:
        """First and last frame of all signs; None: there are none."""
        if not self.signs:
            return None
        return min(s.frames[0] for s in self.signs.values()), max(s.frames[-1] for s in self.signs.values())


def read_expectation(path: Path) -> Expectation:
    """Read an ``expectation.json``.

    Raises:
        ImportFormatError: the file cannot be read or breaks a rule; names the first one.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return Expectation.model_validate(content)
    except OSError as error:
        raise ImportFormatError(f"Cannot read {path}: {error.strerror}. Check the path.") from None
    except ValidationError as error:
        first = error.errors()[0]
        key_path = ".".join(map(str, first["loc"])) or "it"
        raise ImportFormatError(f"{path.name}, {key_path[:120]}: {first['msg'][:200]}. See docs/bundles.md.") from None
    except (ValueError, RecursionError):
        raise ImportFormatError(f"{path.name} is not JSON. See docs/bundles.md for what it holds.") from None
