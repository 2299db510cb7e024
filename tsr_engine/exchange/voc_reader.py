"""Reads Pascal VOC; which pixel a corner means is decided once for all files."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import NamedTuple

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.beside import told_by_manifest
from tsr_engine.exchange.checks import Intake, refuse
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.linking import LooseBoxes
from tsr_engine.exchange.notes import notes_from_text
from tsr_engine.exchange.picture_rows import Listed, names_in
from tsr_engine.exchange.small_xml import SMALL, XmlNode, small_elements
from tsr_engine.exchange.spool import Spool, content_of, names_below
from tsr_engine.exchange.whose_pictures import frames_of_pictures
from tsr_engine.exchange.xml import elements
from tsr_engine.io.plain_numbers import real_number

__all__ = ["annotations_in", "read_voc"]

_WANTED = ("filename", "folder", "size", "object")
_CORNERS = ("xmin", "ymin", "xmax", "ymax")
_TRUE = ("1", "true", "True")


class _Object(NamedTuple):
    """One object of a file, without its XML: there can be hundreds of thousands."""

    line: int
    corners: tuple[float, ...]
    label: int
    uid: str
    key: bool
    occluded: bool
    ignore: bool
    score: float


class _Picture(NamedTuple):
    """What a file says, without the objects' XML; ``size`` is width and height, 0 where it has none."""

    file: str
    filename: str
    folder: str
    size: tuple[float, float]
    size_line: int
    objects: list[_Object]


def read_voc(path: Path, target: ImportTarget) -> Dataset:
    """Read a folder or file.

    Raises:
        ImportFormatError: a broken rule.
    """
    intake = Intake(target)
    folder, files = _files(path, target.spool)
    if not files and not (path / "ImageSets").is_dir():
        raise refuse(path.name, None, "has no Annotations/*.xml. Export as Pascal VOC again.")
    # What the first box of a track says of it: its picture, and state, source and note.
    about: dict[str, tuple[int, str, str, str]] = {}
    pictures = [_read_file(f"{folder}/{file}", place, intake, about) for place, file in enumerate(files)]
    listed = [
        Listed(f"{each.folder}/{file}" if each.folder else file, each.file, instead=each.filename)
        for file, each in zip(files, pictures, strict=True)
    ]
    more = [picture for file in sorted(path.glob("ImageSets/Main/*.txt")) for picture in names_in(file)]
    frames = frames_of_pictures(listed, intake, path if path.is_dir() else path.parent, more)
    taken = [(each, frame) for each, frame in zip(pictures, frames, strict=True) if frame is not None]
    offset = _offset(path, [each for each, _ in taken], intake)
    loose = LooseBoxes(intake, path.name)
    for each, frame in taken:
        wide, high = intake.scale(*each.size, each.file, each.size_line) if any(each.size) else (1.0, 1.0)
        for found in each.objects:
            x1, y1, x2, y2 = found.corners
            edges = ((x1 - offset) * wide, (y1 - offset) * high, x2 * wide, y2 * high)
            uid = found.uid
            known = uid in intake
            # A box without a name waits until all are known.
            take = partial(intake.box, uid) if uid else loose.add
            kept = take(
                frame,
                edges,
                found.label,
                file=each.file,
                line=found.line,
                key=found.key,
                occluded=found.occluded,
                ignore=found.ignore,
                score=found.score,
            )
            if uid and kept and not known:
                first, state, source, note = about[uid]
                notes = notes_from_text(note, frames[first] or 0)
                intake.describe(uid, state=state, source=source, notes=notes)
    loose.settle()
    return intake.finish(path.name)


def annotations_in(path: Path) -> Path:
    """The folder of the XML files."""
    return path / "Annotations" if (path / "Annotations").is_dir() else path


def _files(path: Path, spool: Spool | None) -> tuple[Path, list[str]]:
    """A folder, and the names of the XML files in it and below, sorted; plain names, since there can be 100,000."""
    if path.is_file():
        return path.parent, [path.name]
    folder = annotations_in(path)
    return folder, [name for name in names_below(folder, spool) if name.endswith(".xml")]


def _read_file(path: str, place: int, intake: Intake, about: dict[str, tuple[int, str, str, str]]) -> _Picture:
    """What a file says; what it says of a track goes into ``about`` when it first comes."""
    name = sys.intern(path.rpartition("/")[2])
    spool = intake.target.spool
    small = small_elements(content_of(path, spool, SMALL + 1), "annotation", _WANTED)
    if small is not None:
        try:
            return _picture_of(small, name, place, intake, about)
        except ImportFormatError:
            pass  # once more, with the line of every element
    return _picture_of(elements(_on_disk(path, spool), "annotation", _WANTED), name, place, intake, about)


def _on_disk(path: str, spool: Spool | None) -> Path:
    return Path(path) if spool is None else spool.on_disk(path)


def _picture_of(
    nodes: Iterable[XmlNode], file: str, place: int, intake: Intake, about: dict[str, tuple[int, str, str, str]]
) -> _Picture:
    filename, folder, size, line = "", "", (0.0, 0.0), 0
    objects: list[_Object] = []
    for node in nodes:
        if node.tag == "filename":
            filename = node.text
        elif node.tag == "folder":
            folder = sys.intern(node.text)
        elif node.tag == "size":
            size, line = (_real(node, "width", file), _real(node, "height", file)), node.line
        else:
            box = node.child("bndbox")
            if box is None:
                raise refuse(file, node.line, "<object> must have <bndbox>. Correct it.")
            corners = tuple(_real(box, name, file) for name in _CORNERS)
            objects.append(_object(node, corners, file, place, intake, about))
    return _Picture(file, filename, folder, size, line, objects)


def _offset(path: Path, found: list[_Picture], intake: Intake) -> int:
    """1 where corners count from 1, else 0: as said, as our manifest tells, else by the numbers of all files."""
    asked = intake.target.switches.get("coordinates", "auto")
    zero = next(((each, one) for each in found for one in each.objects if min(one.corners[:2]) < 1), None)
    if asked == "auto":
        asked = told_by_manifest(path if path.is_dir() else path.parent, "coordinates") or asked
    if asked == "devkit":
        if zero is not None:
            raise refuse(
                zero[0].file,
                zero[1].line,
                "a corner below 1 cannot count from 1 as the VOC devkit does. Import with coordinates=cvat.",
            )
        return 1
    corners = [value for each in found for one in each.objects for value in one.corners]
    if asked == "cvat" or not corners:
        return 0
    whole = all(value == int(value) for value in corners if math.isfinite(value))
    if whole and zero is None:
        intake.repair(
            f"{path.name}: corners are whole numbers from 1 on, as in the VOC devkit; xmin and ymin were lowered by 1 "
            "(coordinates=cvat leaves them)."
        )
        return 1
    why = "some have decimals" if not whole else "one lies below 1"
    intake.repair(f"{path.name}: corners were taken as edges from 0, as CVAT writes them, since {why}.")
    return 0


def _real(node: XmlNode, name: str, file: str) -> float:
    try:
        return real_number(node.value(name))
    except ValueError:
        child = node.child(name)
        line = node.line if child is None else child.line
        got = "nothing" if child is None else repr(child.text[:40])
        raise refuse(file, line, f"<{name}> of <{node.tag}> must be a number. Got {got}.") from None


def _object(
    node: XmlNode,
    corners: tuple[float, ...],
    file: str,
    place: int,
    intake: Intake,
    about: dict[str, tuple[int, str, str, str]],
) -> _Object:
    attributes = node.child("attributes")
    said = {} if attributes is None else attributes.table("attribute", "name", "value")
    number = said.get("score", node.value("score")).strip()
    try:
        score = real_number(number) if number else math.nan
    except ValueError:
        raise refuse(file, node.line, f"score must be a number. Got {number[:40]!r}.") from None
    track = said.get("track_id", "").strip()
    uid = said.get("uid", "") or (f"track{track}" if track else "")
    if uid and uid not in about:
        source = said.get("source", "").strip() or "imported"
        about[uid] = place, said.get("state", "open").strip(), source, said.get("note", "")
    return _Object(
        node.line,
        corners,
        intake.label(node.value("name"), file, node.line),
        sys.intern(uid),
        key=said.get("keyframe", "true").strip() in _TRUE,
        occluded=node.value("occluded") in _TRUE or said.get("occluded", "").strip() in _TRUE,
        ignore=node.value("difficult") in _TRUE,
        score=score,
    )
