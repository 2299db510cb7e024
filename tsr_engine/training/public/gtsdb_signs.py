"""Reads annotations that ``gt.txt`` of GTSDB lacks: signs outside the 43 classes, and regions to ignore."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from tsr_engine.errors import InputError
from tsr_engine.geometry.boxes import area, intersection
from tsr_engine.io.gtsdb import Scene
from tsr_engine.labels.files import VIENNA, shipped_set
from tsr_engine.records import FloatArray

__all__ = ["Annotation", "Annotations", "Reason", "ignoring", "other_signs", "read_signs"]

_WITHIN: Final = 0.8
"""A sign with a larger share of its area inside another one counts as a part of that sign."""
Reason = Literal["", "not in the label set", "unread", "on a vehicle", "small", "board"]


class Annotation(BaseModel):
    """One sign.

    Attributes:
        id: unique number, from 1.
        scene: stem of the picture.
        box: ``x1, y1, x2, y2``, pixel edges.
        label: key in the label set; None: the set lacks the sign, or it is unreadable.
        kind: a sign, a supplementary plate, or a board that is neither. Signs that the label set lacks count as plates,
            because nearly all of them are.
        ignore: the region is not used for training, and evaluation counts neither a hit nor a miss.
        reason: why it is ignored.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    id: int = Field(ge=1)
    scene: str = Field(pattern=r"^\d{5}$")
    box: tuple[float, float, float, float]
    label: str | None
    kind: Literal["sign", "plate", "board"]
    ignore: bool
    reason: Reason


class Annotations(BaseModel):
    """The file.

    Attributes:
        about: how the annotations were made.
        label_set: key of the label set.
        figures: agreement between the annotator's passes.
        signs: by scene, from top to bottom.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    about: str
    label_set: str
    figures: dict[str, int | float]
    signs: tuple[Annotation, ...]


def read_signs(path: Path) -> Annotations:
    """Read the annotations of a file.

    Raises:
        InputError: the file is unreadable or has another form, a label that the label set lacks, a box without
            area, or a sign for training without a label.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"Cannot read the annotations {path}: {error}. Name a JSON file of annotated signs.") from None
    try:
        found = Annotations.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise InputError(f"{path}, {where or 'whole file'}: {first['msg']}. Correct the annotations.") from None
    if found.label_set != VIENNA:
        raise InputError(f"{path}: the label set must be {VIENNA!r}. Got {found.label_set!r} instead.")
    keys = {label.key for label in shipped_set(VIENNA)}
    for sign in found.signs:
        x1, y1, x2, y2 = sign.box
        if not (x1 < x2 and y1 < y2):
            raise InputError(f"{path}, sign {sign.id}: the box {list(sign.box)} has no area. Correct it.")
        if sign.label is not None and sign.label not in keys:
            raise InputError(f"{path}, sign {sign.id}: {VIENNA!r} has no label {sign.label!r}. Correct it.")
        if sign.label is None and not sign.ignore:
            raise InputError(
                f"{path}, sign {sign.id}: a sign to learn from needs a label. Name it, or ignore the sign."
            )
    return found


def ignoring(scenes: Sequence[Scene], annotations: Annotations) -> list[Scene]:
    """The scenes with all annotated signs ignored, because other signs are not background.

    Raises:
        InputError: no annotation belongs to these scenes.
    """
    places = _by_scene(scenes, annotations.signs)
    return [replace(scene, ignored=_boxes([s.box for s in places[scene.path.stem]])) for scene in scenes]


def other_signs(scenes: Sequence[Scene], annotations: Annotations) -> list[Scene]:
    """The scenes with the annotated signs as signs, by their ids in the label set.

    The signs of ``gt.txt``, plates and all ignored regions are ignored; but the limit in a zone sign is background,
    because the sign is the whole rectangle.

    Raises:
        InputError: no annotation belongs to these scenes.
    """
    ids = {label.key: label.id for label in shipped_set(VIENNA)}
    places = _by_scene(scenes, annotations.signs)
    out = []
    for scene in scenes:
        here = places[scene.path.stem]
        signs = [s for s in here if s.kind == "sign" and not s.ignore]
        rest = [s.box for s in here if s.kind != "sign" or s.ignore]
        own = _boxes([s.box for s in signs])
        within = intersection(scene.boxes, own).max(axis=1, initial=0.0) > _WITHIN * area(scene.boxes)
        out.append(
            replace(
                scene,
                boxes=own,
                class_ids=np.array([ids[s.label] for s in signs if s.label is not None], np.int64),
                ignored=np.concatenate([scene.boxes[~within], scene.ignored, _boxes(rest)]),
            )
        )
    return out


def _by_scene(scenes: Sequence[Scene], signs: Sequence[Annotation]) -> dict[str, list[Annotation]]:
    places: dict[str, list[Annotation]] = {scene.path.stem: [] for scene in scenes}
    for sign in signs:
        if sign.scene in places:
            places[sign.scene].append(sign)
    if signs and not any(places.values()):
        raise InputError("None of the annotated signs is in these scenes. Name the annotations of this GTSDB folder.")
    return places


def _boxes(rows: Sequence[tuple[float, ...]]) -> FloatArray:
    return np.array(rows, np.float64).reshape(-1, 4)
