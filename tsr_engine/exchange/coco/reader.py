"""Reads COCO: files of annotations, and lists of results."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import TypeVar

from tsr_engine.exchange.attributes import BOX_NAMES, label_values, parse_attributes, track_facts
from tsr_engine.exchange.box_rules import Edges, check_pixels, scaled
from tsr_engine.exchange.coco.images import CocoHead, find_image_frames, missing_list_error, read_head
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.file_listing import list_json_files
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.frames_of_pictures import frames_of_pictures
from tsr_engine.exchange.ids import id_of, real_of, track_of, whole_of
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.json_stream import members
from tsr_engine.exchange.linking import UntrackedBoxes
from tsr_engine.exchange.picture_sequences import ListedPicture
from tsr_engine.exchange.reading import rule_error
from tsr_engine.exchange.rotated_boxes import bounding_box
from tsr_engine.json_shapes import JsonObject

_T = TypeVar("_T")

_TRUE_VALUES = (True, 1, "true", "True", "1")


def read_coco(path: Path, target: ImportTarget) -> Dataset:
    """Read a COCO file or a folder of such files.

    Raises:
        ImportFormatError: a file breaks a rule.
    """
    validator = ImportValidator(target)
    files = list_json_files(path)
    if not files:
        raise rule_error(path.name, None, "has no annotations/*.json. Export as COCO again.")
    folder = path if path.is_dir() else path.parent
    loose = UntrackedBoxes(validator, files[0].name)
    heads = {file: read_head(file, _display_name(file, folder)) for file in files}
    known = [head for head in heads.values() if head is not None]
    find_image_frames(known, validator, folder)
    file_of_track: dict[str, str] = {}
    for file, head in heads.items():
        if head is not None:
            _Annotations(file, head, validator, loose, file_of_track).read()
    for file, head in heads.items():
        if head is None:
            _Results(file, known, validator, loose, folder).read()
    loose.finish()
    return validator.finish(files[0].name, interpolate=target.switches.get("interpolate") == "yes")


def _display_name(file: Path, folder: Path) -> str:
    """The name of a file for messages: Roboflow uses one name for the files of all subsets."""
    return file.name if file.parent in (folder, folder / "annotations") else f"{file.parent.name}/{file.name}"


class _Annotations:
    """The annotations of a file whose head has been read."""

    def __init__(
        self,
        path: Path,
        head: CocoHead,
        validator: ImportValidator,
        loose: UntrackedBoxes,
        file_of_track: dict[str, str],
    ) -> None:
        """Take the head; ``file_of_track`` holds the first file of each track id, for all files."""
        self._path = path
        self._name = head.file
        self._head = head
        self._validator = validator
        self._loose = loose
        self._file_of_track = file_of_track
        self._seen: set[int | str] = set()

    def read(self) -> None:
        """Take all annotations; only one is in memory at a time."""
        for key, position, value in members(self._path):
            if key != "annotations":
                continue
            if position is None or (position and not isinstance(value, dict)):
                raise missing_list_error(self._name, key)
            if position:
                self._annotation(value, f"annotation {position}")

    def _annotation(self, annotation: JsonObject, where: str) -> None:
        key = id_of(annotation.get("id"))
        if key is not None:
            if key in self._seen:
                self._validator.count("Repeated annotation ids were ignored", self._name, where)
            self._seen.add(key)
        image = _look_up(self._head.images, annotation.get("image_id"), "image", self._name, where)
        if image is None:
            return
        label = _look_up(self._head.categories, annotation.get("category_id"), "category", self._name, where)
        if annotation.get("bbox") is None:
            self._validator.skip(f"{self._name}, {where}", "It has no bbox.")
            return
        attributes = annotation.get("attributes")
        attributes = attributes if isinstance(attributes, dict) else {}
        score = attributes.get("score", annotation.get("score"))
        box_fields: JsonObject = {
            "file": self._name,
            "line": where,
            "key": attributes.get("keyframe", True) in _TRUE_VALUES,
            "occluded": attributes.get("occluded", False) in _TRUE_VALUES,
            "ignore": annotation.get("iscrowd", 0) in _TRUE_VALUES
            or any(holder.get("ignore", False) in _TRUE_VALUES for holder in (annotation, attributes)),
            "score": math.nan if score is None else real_of(score, "score", self._name, where),
            "attributes": parse_attributes(label_values(attributes, BOX_NAMES), self._name, where),
        }
        edges = self._validator.boxes.edges(lambda: self._edges(annotation["bbox"], attributes, image.scale, where))
        number = self._validator.label(label, self._name, where)
        uid = str(attributes.get("uid", "")) or self._track(annotation, attributes, where)
        if not uid:
            self._loose.add(image.frame, edges, number, **box_fields)
            return
        if attributes.get("outside", False) in _TRUE_VALUES:
            self._validator.hide_from(uid, image.frame)
            return
        self._validator.box(uid, image.frame, edges, number, facts=track_facts(attributes), **box_fields)

    def _edges(self, box: object, attributes: JsonObject, scale: tuple[float, float], where: str) -> Edges:
        """Edges in px of the video; a rotated box is replaced by the upright box around it."""
        edges, rotation = _edges(box, self._name, where), attributes.get("rotation")
        if not attributes.get("uid"):
            check_pixels(edges, self._name, where)
        if rotation:
            degrees = real_of(rotation, "rotation", self._name, where, in_text=True)
            edges = bounding_box(edges, degrees, self._validator, self._name, where)
        return scaled(edges, scale)

    def _track(self, annotation: JsonObject, attributes: JsonObject, where: str) -> str:
        """Name of an annotation's track, by CVAT's or CocoVID's id; empty: it has none."""
        for name, holder in (("track_id", attributes), ("track_id", annotation), ("instance_id", annotation)):
            found = track_of(holder.get(name), name, self._name, where)
            if found is None:
                continue
            uid = f"track{found}"
            if self._file_of_track.setdefault(uid, self._name) != self._name:
                what = "Boxes became part of a track of an earlier file, which has the same track id"
                self._validator.count(what, self._name, where)
            return uid
        return ""


class _Results:
    """A flat list of results; ids are counted if the list comes without its images."""

    def __init__(
        self, path: Path, heads: list[CocoHead], validator: ImportValidator, loose: UntrackedBoxes, folder: Path
    ) -> None:
        self._path = path
        self._name = path.name
        self._validator = validator
        self._loose = loose
        self._folder = folder
        self._without_images = not any(head.images for head in heads)
        self._images = _merged([head.images for head in heads])
        self._names = _merged([head.categories for head in heads])
        self._frames: dict[str, int | None] = {}
        self._first_id = int(validator.target.switches.get("first_id", "1"))

    def read(self) -> None:
        """Take all results; only one is in memory at a time."""
        if self._without_images:
            self._find_frames()
        number = 0
        for _, position, result in members(self._path):
            if not position:
                continue
            number, where = position, f"result {position}"
            if not isinstance(result, dict):
                raise rule_error(self._name, where, "must be an object. Correct it.")
            self._result(result, where)
        if self._without_images and number:
            self._validator.repair(
                f"{self._name}: comes without images and categories; image and category ids were taken as frames and "
                f"class numbers, counted from {self._first_id} (first_id)."
            )

    def _find_frames(self) -> None:
        """Find the frames of image ids that are picture names; this needs all of them."""
        listed: dict[str, ListedPicture] = {}
        for _, position, result in members(self._path):
            key = id_of(result.get("image_id")) if position and isinstance(result, dict) else None
            if isinstance(key, str) and not key.isdigit():
                listed.setdefault(key, ListedPicture(key, self._name, f"result {position}"))
        frames = frames_of_pictures(list(listed.values()), self._validator, self._folder)
        self._frames = dict(zip(listed, frames, strict=True))

    def _result(self, result: JsonObject, where: str) -> None:
        key, category = id_of(result.get("image_id")), result.get("category_id")
        scale = (1.0, 1.0)
        if self._without_images:
            if isinstance(key, str) and key in self._frames:
                found = self._frames[key]
                if found is None:
                    return
                frame = found
            else:
                number = int(key) if isinstance(key, str) else whole_of(key, "image_id", self._name, where)
                frame = self._validator.frame(number, self._name, where, origin=self._first_id)
            number = whole_of(category, "category_id", self._name, where) - self._first_id
            label = self._validator.label(str(number), self._name, where, number=True)
        else:
            image = _look_up(self._images, key, "image", self._name, where)
            if image is None:
                return
            frame, scale = image.frame, image.scale
            label = self._validator.label(
                _look_up(self._names, category, "category", self._name, where), self._name, where
            )
        score, track = result.get("score"), track_of(result.get("track_id"), "track_id", self._name, where)
        # Boxes without a track id are linked when all are known.
        add_box = self._loose.add if track is None else partial(self._validator.box, f"track{track}")
        add_box(
            frame,
            self._validator.boxes.edges(lambda: scaled(_edges(result.get("bbox"), self._name, where), scale)),
            label,
            file=self._name,
            line=where,
            score=math.nan if score is None else real_of(score, "score", self._name, where),
        )


def _merged(tables: list[dict[object, _T]]) -> dict[object, _T]:
    """Join the tables of several files; an id with two meanings is left out."""
    out: dict[object, _T] = {}
    twice: set[object] = set()
    for table in tables:
        for key, value in table.items():
            if out.setdefault(key, value) != value:
                twice.add(key)
    return {key: value for key, value in out.items() if key not in twice}


def _look_up(table: dict[object, _T], key: object, kind: str, file: str, where: str) -> _T:
    found = id_of(key)
    if found is None or found not in table:
        raise rule_error(file, where, f"{kind}_id {str(key)[:40]!r} matches no {kind}, or several. Correct it.")
    return table[found]


def _edges(box: object, file: str, where: str) -> Edges:
    if not isinstance(box, list) or len(box) != 4:
        raise rule_error(file, where, f"bbox must be four numbers x, y, width, height. Got {str(box)[:80]}.")
    x, y, width, height = (real_of(side, "bbox", file, where) for side in box)
    return x, y, x + width, y + height
