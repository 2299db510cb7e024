"""Reads Pascal VOC; the meaning of corners is decided once for all files."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import NamedTuple

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.attributes import BOX_NAMES, label_values, track_facts
from tsr_engine.exchange.box_rules import NO_BOX, Edges
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.frames_of_pictures import frames_of_pictures
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.linking import UntrackedBoxes
from tsr_engine.exchange.nearby_manifest import manifest_value
from tsr_engine.exchange.picture_sequences import ListedPicture, read_picture_list
from tsr_engine.exchange.reading import rule_error
from tsr_engine.exchange.small_file_store import SmallFileStore, list_all_files, read_content
from tsr_engine.exchange.voc.small_xml import MAX_SMALL_BYTES, XmlNode, small_elements
from tsr_engine.exchange.xml import elements
from tsr_engine.io.plain_numbers import parse_real

_ELEMENTS = ("filename", "folder", "path", "size", "object")
_CORNERS = ("xmin", "ymin", "xmax", "ymax")
_TRUE_VALUES = ("1", "true", "True")
_NO_POSE = ("", "Unspecified", "unspecified")
_SharedTexts = dict[tuple[str, str, str], tuple[str, str, str]]


class _Object(NamedTuple):
    """One object of a file without its XML, because there can be hundreds of thousands.

    It is checked once its picture is known to be of the video, so ``corners`` may hold the error about them.
    """

    line: int
    corners: Edges | ImportFormatError
    name: str
    uid: str
    key: bool
    occluded: bool
    ignore: bool
    score: float
    track_facts: tuple[str, str, str]
    """State, source and note of its track."""
    attributes: dict[str, str] | None
    """Attributes of its label."""


class _Picture(NamedTuple):
    """The content of a file without the objects' XML; ``size`` is width and height, 0 if missing."""

    file: str
    filename: str
    folder: str
    size: tuple[float, float]
    size_line: int
    objects: list[_Object]


def read_voc(path: Path, target: ImportTarget) -> Dataset:
    """Read a folder or file.

    Raises:
        ImportFormatError: a file breaks a rule.
    """
    validator = ImportValidator(target)
    folder, files = _files(path, target.store)
    if not files and not (path / "ImageSets").is_dir():
        raise rule_error(path.name, None, "has no Annotations/*.xml. Export as Pascal VOC again.")
    shared: _SharedTexts = {}
    pictures = [_read_file(f"{folder}/{file}", validator.target.store, shared) for file in files]
    listed = [
        ListedPicture(f"{each.folder}/{file}" if each.folder else file, each.file, fallback_name=each.filename)
        for file, each in zip(files, pictures, strict=True)
    ]
    listed_names = [
        picture for file in sorted(path.glob("ImageSets/Main/*.txt")) for picture in read_picture_list(file)
    ]
    frames = frames_of_pictures(listed, validator, path if path.is_dir() else path.parent, listed_names)
    chosen = [(each, frame) for each, frame in zip(pictures, frames, strict=True) if frame is not None]
    offset = _offset(path, [each for each, _ in chosen], validator)
    loose = UntrackedBoxes(validator, path.name)
    for each, frame in chosen:
        scale_x, scale_y = validator.scale(*each.size, each.file, each.size_line) if any(each.size) else (1.0, 1.0)
        for found in each.objects:
            corners = validator.boxes.edges(partial(_corners, found))
            if corners is NO_BOX:
                continue
            x1, y1, x2, y2 = corners
            edges = ((x1 - offset) * scale_x, (y1 - offset) * scale_y, x2 * scale_x, y2 * scale_y)
            # Boxes without a track name are linked when all are known.
            add_box = partial(validator.box, found.uid, facts=found.track_facts) if found.uid else loose.add
            add_box(
                frame,
                edges,
                validator.label(found.name, each.file, found.line),
                file=each.file,
                line=found.line,
                key=found.key,
                occluded=found.occluded,
                ignore=found.ignore,
                score=found.score,
                attributes=found.attributes,
            )
    loose.finish()
    return validator.finish(path.name)


def annotation_folder(path: Path) -> Path:
    """The folder of the XML files."""
    return path / "Annotations" if (path / "Annotations").is_dir() else path


def _files(path: Path, store: SmallFileStore | None) -> tuple[Path, list[str]]:
    """A folder and the sorted names of XML files below it; plain strings, because there can be 100,000."""
    if path.is_file():
        return path.parent, [path.name]
    folder = annotation_folder(path)
    return folder, [name for name in list_all_files(folder, store) if name.endswith(".xml")]


def _read_file(path: str, store: SmallFileStore | None, shared: _SharedTexts) -> _Picture:
    """Read a file; equal texts about tracks are stored once, in ``shared``."""
    name = sys.intern(path.rpartition("/")[2])
    small = small_elements(read_content(path, store, MAX_SMALL_BYTES + 1), "annotation", _ELEMENTS)
    if small is not None:
        try:
            picture = _picture_of(small, name, shared)
            if all(isinstance(each.corners, tuple) for each in picture.objects):
                return picture
        except ImportFormatError:
            pass
    # Read again, with the line of every element.
    on_disk = Path(path) if store is None else store.on_disk(path)
    return _picture_of(elements(on_disk, "annotation", _ELEMENTS), name, shared)


def _picture_of(nodes: Iterable[XmlNode], file: str, shared: _SharedTexts) -> _Picture:
    filename, folder, size, line = "", "", (0.0, 0.0), 0
    objects: list[_Object] = []
    for node in nodes:
        if node.tag == "filename":
            filename = node.text
        elif node.tag == "folder":
            folder = sys.intern(node.text) or folder
        elif node.tag == "path":
            folder = folder or sys.intern(node.text.replace("\\", "/").rpartition("/")[0].rpartition("/")[2])
        elif node.tag == "size":
            size, line = (_real(node, "width", file), _real(node, "height", file)), node.line
        else:
            objects.append(_object(node, file, shared))
    return _Picture(file, filename, folder, size, line, objects)


def _offset(path: Path, found: list[_Picture], validator: ImportValidator) -> int:
    """1 if corners count from 1, else 0: by the switch, by our manifest, or by the numbers of all files."""
    option = validator.target.switches.get("coordinates", "auto")
    boxes = [(each, obj, obj.corners) for each in found for obj in each.objects if isinstance(obj.corners, tuple)]
    below_one = next(((each, obj) for each, obj, corners in boxes if min(corners[:2]) < 1), None)
    if option == "auto":
        option = manifest_value(path if path.is_dir() else path.parent, "coordinates") or option
    if option == "devkit":
        if below_one is not None:
            raise rule_error(
                below_one[0].file,
                below_one[1].line,
                "a corner below 1 cannot count from 1 as in the VOC devkit. Import with coordinates=cvat.",
            )
        return 1
    if option == "cvat" or not boxes:
        return 0
    all_whole = all(value == int(value) for *_, corners in boxes for value in corners if math.isfinite(value))
    if all_whole and below_one is None:
        validator.repair(
            f"{path.name}: corners are whole numbers from 1 on, as in the VOC devkit; xmin and ymin were lowered by 1 "
            "(coordinates=cvat leaves them)."
        )
        return 1
    reason = "some have decimals" if not all_whole else "one lies below 1"
    validator.repair(f"{path.name}: corners were taken as edges from 0, as CVAT writes them, since {reason}.")
    return 0


def _real(node: XmlNode, name: str, file: str) -> float:
    try:
        return parse_real(node.value(name))
    except ValueError:
        child = node.child(name)
        line = node.line if child is None else child.line
        got = "nothing" if child is None else repr(child.text[:40])
        raise rule_error(file, line, f"<{name}> of <{node.tag}> must be a number. Got {got}.") from None


def _corners(found: _Object) -> Edges:
    if isinstance(found.corners, ImportFormatError):
        raise found.corners
    return found.corners


def _corners_of(node: XmlNode, file: str) -> Edges | ImportFormatError:
    box = node.child("bndbox")
    if box is None:
        return rule_error(file, node.line, "<object> must have <bndbox>. Correct it.")
    try:
        x1, y1, x2, y2 = (_real(box, name, file) for name in _CORNERS)
    except ImportFormatError as error:
        return error
    return x1, y1, x2, y2


def _object(node: XmlNode, file: str, shared: _SharedTexts) -> _Object:
    attributes_node = node.child("attributes")
    box_attributes = {} if attributes_node is None else attributes_node.table("attribute", "name", "value")
    number = box_attributes.get("score", node.value("score")).strip()
    try:
        score = parse_real(number) if number else math.nan
    except ValueError:
        raise rule_error(file, node.line, f"score must be a number. Got {number[:40]!r}.") from None
    track = box_attributes.get("track_id", "").strip() or node.value("trackid")
    uid = box_attributes.get("uid", "") or (f"track{track}" if track else "")
    facts = track_facts(box_attributes)
    attributes_of_label = label_values(box_attributes, BOX_NAMES - {"ignore"})
    # VOC's own flags that are informative
    if node.value("truncated") in _TRUE_VALUES:
        attributes_of_label.setdefault("truncated", "true")
    if node.value("pose") not in _NO_POSE:
        attributes_of_label.setdefault("pose", node.value("pose"))
    return _Object(
        node.line,
        _corners_of(node, file),
        sys.intern(node.value("name")),
        sys.intern(uid),
        key=box_attributes.get("keyframe", "true").strip() in _TRUE_VALUES,
        occluded=node.value("occluded") in _TRUE_VALUES or box_attributes.get("occluded", "").strip() in _TRUE_VALUES,
        ignore=node.value("difficult") in _TRUE_VALUES,
        score=score,
        track_facts=shared.setdefault(facts, facts),
        attributes=attributes_of_label or None,
    )
