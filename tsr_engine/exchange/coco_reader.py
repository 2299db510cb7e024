"""Reads COCO: files of annotations, and lists of results."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.checks import Intake, refuse
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.json_stream import OPENED, members
from tsr_engine.exchange.linking import LooseBoxes
from tsr_engine.exchange.notes import notes_from_text
from tsr_engine.exchange.picture_lists import PictureNames

__all__ = ["coco_files", "read_coco"]

_LISTS = frozenset({"categories", "images", "annotations"})
_IMAGE = ("id", "file_name", "frame", "width", "height", "video_sha256")
_TRUE = (True, 1, "true", "True", "1")


@dataclass(slots=True)
class _Image:
    """An image of the video: its frame and the factors to the video's size."""

    frame: int
    scale: tuple[float, float]


def coco_files(path: Path) -> list[Path]:
    """The JSON files of a folder, or the file."""
    if path.is_file():
        return [path]
    inside = path / "annotations" if (path / "annotations").is_dir() else path
    return sorted(file for file in inside.glob("*.json") if file.name != "manifest.json")


def read_coco(path: Path, target: ImportTarget) -> Dataset:
    """Read a file or folder.

    Raises:
        ImportFormatError: a broken rule.
    """
    intake = Intake(target)
    files = coco_files(path)
    if not files:
        raise refuse(path.name, None, "has no annotations/*.json. Export as COCO again.")
    loose = LooseBoxes(intake, files[0].name)
    pictures = PictureNames(path if path.is_dir() else path.parent, target.video)
    others = 0
    images: dict[Any, _Image | None] = {}
    names: dict[Any, str] = {}
    lists: list[Path] = []
    for file in files:
        reader = _File(file, intake, loose, pictures)
        if not reader.read():
            lists.append(file)
            continue
        others += reader.others
        images |= reader.images
        names |= reader.categories
    for file in lists:
        results = _Results(file, intake, loose, images, names, pictures)
        results.read()
        others += results.others
    if others:
        intake.skip(f"{others} pictures", f"They are of another video than {target.video.name}.")
    loose.settle()
    return intake.finish(files[0].name, interpolate=target.switches.get("interpolate") == "yes")


class _File:
    """One file with images, categories and annotations."""

    def __init__(self, path: Path, intake: Intake, loose: LooseBoxes, pictures: PictureNames) -> None:
        self._path = path
        self._name = path.name
        self._intake = intake
        self._loose = loose
        self._pictures = pictures
        self._listed: list[dict[str, Any]] = []
        self._hashes: dict[Any, Any] = {}
        self._seen: set[Any] = set()
        self.images: dict[Any, _Image | None] = {}
        self.categories: dict[Any, str] = {}
        self.others = 0

    def read(self) -> bool:
        """Take all annotations, one in memory at a time; False: it is a list of results.

        Images and categories come first in most files. Where they do not, the file is read once more.
        """
        there: set[str] = set()
        late = False
        for key, place, value in members(self._path):
            if key == "":
                if place is None:
                    raise refuse(
                        self._name,
                        None,
                        "must be an object with images, categories and annotations, or a list of results.",
                    )
                return False
            if key != "images" and self._listed:
                self._take_images()
            if key not in _LISTS:
                continue
            if place is None or (place and not isinstance(value, dict)):
                raise self._no_list(key)
            there.add(key)
            if key == "annotations" and place == OPENED:
                late = not {"images", "categories"} <= there
            if place and (key != "annotations" or not late):
                self._entry(key, place, value)
        self._take_images()
        for key in ("categories", "images"):
            if key not in there:
                raise self._no_list(key)
        if late:
            for key, place, value in members(self._path):
                if key == "annotations" and place:
                    self._entry(key, place, value)
        return True

    def _no_list(self, key: str) -> ImportFormatError:
        return refuse(self._name, None, f"must have {key}, a list of objects. Export as COCO again.")

    def _entry(self, key: str, place: int, entry: dict[str, Any]) -> None:
        if key == "images":
            # The few keys that count, and one text for all equal hashes: there can be 100,000 of these.
            image = {name: entry[name] for name in _IMAGE if name in entry}
            if "video_sha256" in image and isinstance(image["video_sha256"], str):
                image["video_sha256"] = self._hashes.setdefault(image["video_sha256"], image["video_sha256"])
            self._listed.append(image)
        elif key == "annotations":
            self._annotation(entry, f"annotation {place}", self._seen)
        else:
            where = f"category {place}"
            number = _key(entry.get("id"), self._name, where)
            if number in self.categories:
                raise refuse(self._name, where, f"its id {number} is there twice. Give each category its own.")
            self.categories[number] = str(entry.get("name", ""))

    def _take_images(self) -> None:
        """Find the frames of the images, once all of them are known."""
        told = {str(image.get("video_sha256", "")) for image in self._listed}
        own = self._intake.target.video.sha256
        # The hash of the video whose images count, where the images tell of several.
        about = own if len(told) > 1 and own in told and own else ""
        for number, image in enumerate(self._listed, start=1):
            self._image(image, f"image {number}", about)
        self._listed.clear()

    def _image(self, image: dict[str, Any], where: str, about: str) -> None:
        key = _key(image.get("id"), self._name, where)
        if key in self.images:
            raise refuse(self._name, where, f"its id {key} is there twice. Give each image its own.")
        name = str(image.get("file_name", ""))
        if about and image.get("video_sha256") != about:
            frame = None
        else:
            frame = self._pictures.frame(name)
            if "frame" in image and (about or frame is not None or not self._pictures.is_other(name)):
                frame = self._intake.frame(image["frame"], self._name, where)
            elif frame is None and not self._pictures.is_other(name):
                raise refuse(
                    self._name, where, f"{name[:80]!r} has no frame number, and no key frame. Call it frame_000010.jpg."
                )
        if frame is None:
            self.images[key] = None
            self.others += 1
            return
        self._intake.frame(frame, self._name, where)
        self.images[key] = _Image(frame, self._scale(image, where))

    def _scale(self, image: dict[str, Any], where: str) -> tuple[float, float]:
        size = image.get("width"), image.get("height")
        if size == (None, None) or size == (0, 0):
            return 1.0, 1.0
        width, height = (_number(side, "width and height", self._name, where) for side in size)
        return self._intake.scale(width, height, self._name, where)

    def _annotation(self, note: dict[str, Any], where: str, seen: set[Any]) -> None:
        key = note.get("id")
        if isinstance(key, int | str):
            if key in seen:
                self._intake.count("Annotation ids that were there twice were passed over", self._name, where)
            seen.add(key)
        image = _look_up(self.images, note.get("image_id"), "image", self._name, where)
        if image is None:
            return
        label = _look_up(self.categories, note.get("category_id"), "category", self._name, where)
        if note.get("bbox") is None:
            self._intake.skip(f"{self._name}, {where}", "It has no bbox.")
            return
        said = note.get("attributes")
        said = said if isinstance(said, dict) else {}
        score = said.get("score", note.get("score"))
        given: dict[str, Any] = {
            "file": self._name,
            "line": where,
            "key": said.get("keyframe", True) in _TRUE,
            "occluded": said.get("occluded", False) in _TRUE,
            "ignore": note.get("iscrowd", 0) in _TRUE or said.get("ignore", False) in _TRUE,
            "score": math.nan if score is None else _number(score, "score", self._name, where),
        }
        edges = self._intake.edges(lambda: _edges(note["bbox"], image.scale, self._name, where))
        number = self._intake.label(label, self._name, where)
        track = said.get("track_id", note.get("track_id"))
        uid = str(said.get("uid", "")) or (f"track{track}" if track is not None else "")
        if not uid:
            self._loose.add(image.frame, edges, number, **given)
            return
        if said.get("outside", False) in _TRUE:
            self._intake.end(uid, image.frame)
            return
        known = uid in self._intake
        if self._intake.box(uid, image.frame, edges, number, **given) and not known:
            self._intake.describe(
                uid,
                state=str(said.get("state", "open")),
                source=str(said.get("source", "imported")),
                notes=notes_from_text(str(said.get("note", "")), image.frame),
            )


class _Results:
    """A flat list of results; without the images that it belongs to, ids are counted."""

    def __init__(
        self,
        path: Path,
        intake: Intake,
        loose: LooseBoxes,
        images: dict[Any, _Image | None],
        names: dict[Any, str],
        pictures: PictureNames,
    ) -> None:
        self._path = path
        self._name = path.name
        self._intake = intake
        self._loose = loose
        self._images = images
        self._names = names
        self._pictures = pictures
        self._first = int(intake.target.switches.get("first_id", "1"))
        self.others = 0

    def read(self) -> None:
        """Take all results, one in memory at a time."""
        alone = not self._images
        number = 0
        for _, place, result in members(self._path):
            if not place:
                continue
            number, where = place, f"result {place}"
            if not isinstance(result, dict):
                raise refuse(self._name, where, "must be an object. Correct it.")
            self._result(result, where, alone)
        if alone and number:
            self._intake.repair(
                f"{self._name}: comes without images and categories; image and category ids were taken as frames and "
                f"class numbers, counted from {self._first} (first_id)."
            )

    def _result(self, result: dict[str, Any], where: str, alone: bool) -> None:
        key, category = result.get("image_id"), result.get("category_id")
        scale = (1.0, 1.0)
        if alone:
            found = self._alone(key, where)
            if found is None:
                return
            frame = found
            number = _whole(category, "category_id", self._name, where) - self._first
            label = self._intake.label(str(number), self._name, where, number=True)
        else:
            image = _look_up(self._images, key, "image", self._name, where)
            if image is None:
                return
            frame, scale = image.frame, image.scale
            name = _look_up(self._names, category, "category", self._name, where)
            label = self._intake.label(name, self._name, where)
        score = result.get("score")
        self._loose.add(
            frame,
            self._intake.edges(lambda: _edges(result.get("bbox"), scale, self._name, where)),
            label,
            file=self._name,
            line=where,
            score=math.nan if score is None else _number(score, "score", self._name, where),
        )

    def _alone(self, key: Any, where: str) -> int | None:
        """Frame of an image id; None: of another video."""
        if isinstance(key, str) and not key.isdigit():
            frame = self._pictures.frame(key)
            if frame is None:
                if self._pictures.is_other(key):
                    self.others += 1
                    return None
                raise refuse(self._name, where, f"image_id {key[:80]!r} has no frame number. Call it frame_000010.")
            return self._intake.frame(frame, self._name, where)
        return self._intake.frame(_whole(key, "image_id", self._name, where), self._name, where, origin=self._first)


def _key(value: Any, file: str, where: str) -> int | str:
    if type(value) in (int, str):
        return value  # type: ignore[no-any-return]
    raise refuse(file, where, f"id must be a whole number. Got {str(value)[:40]!r}.")


def _look_up(table: dict[Any, Any], key: Any, kind: str, file: str, where: str) -> Any:
    if type(key) not in (int, str) or key not in table:
        raise refuse(file, where, f"{kind}_id {str(key)[:40]!r} is the id of no {kind}. Correct it.")
    return table[key]


def _whole(value: Any, name: str, file: str, where: str) -> int:
    if type(value) is int:
        return value
    if isinstance(value, str) and value.isdigit() and value.isascii() and len(value) < 10:
        return int(value)
    raise refuse(file, where, f"{name} must be a whole number. Got {str(value)[:40]!r}.")


def _number(value: Any, name: str, file: str, where: str) -> float:
    if type(value) not in (int, float):
        got = "null or NaN" if value is None else repr(str(value)[:40])
        raise refuse(file, where, f"{name} must be a finite number. Got {got}.")
    try:
        return float(value)
    except OverflowError:
        raise refuse(file, where, f"{name} is too large. Correct it.") from None


def _edges(box: Any, scale: tuple[float, float], file: str, where: str) -> tuple[float, float, float, float]:
    if not isinstance(box, list) or len(box) != 4:
        raise refuse(file, where, f"bbox must be four numbers x, y, width, height. Got {str(box)[:80]}.")
    x, y, width, height = (_number(side, "bbox", file, where) for side in box)
    return x * scale[0], y * scale[1], (x + width) * scale[0], (y + height) * scale[1]
