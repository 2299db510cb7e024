"""Pascal VOC: one XML file a picture.

Two readings of the corners are about. The devkit counts pixels from 1 and both corners belong to the sign; CVAT and
Datumaro write plain edges from 0. The switch ``coordinates`` says which; only the upper left corner differs, by 1.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from tsr_engine.exchange.beside import told_by_manifest
from tsr_engine.exchange.checks import SIZE_SWITCH, Intake, refuse
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Skipped
from tsr_engine.exchange.formats import ExportOptions, Format, ImportTarget, Switch
from tsr_engine.exchange.labels import label_name, used_labels
from tsr_engine.exchange.linking import LINK_SWITCH, LooseBoxes
from tsr_engine.exchange.notes import notes_from_text, notes_to_text
from tsr_engine.exchange.outlet import Outlet
from tsr_engine.exchange.picture_lists import (
    IMAGE_SWITCH,
    PictureList,
    PictureNames,
    picture_lists,
    subsets_in,
    write_files,
)
from tsr_engine.exchange.rounding import rounded
from tsr_engine.exchange.rows import PlainRows
from tsr_engine.exchange.whole_pixels import whole_pixels
from tsr_engine.exchange.xml import Node, elements, text

__all__ = ["FORMAT"]

_DECIMALS = 2
_GIVEN = ("file", "line", "key", "occluded", "ignore", "score")
_TRUE = ("1", "true", "True")
_KEY = tuple(f"<attribute><name>keyframe</name><value>{word}</value></attribute>" for word in ("false", "true"))


def _write(dataset: Dataset, out: Outlet, options: ExportOptions) -> tuple[list[Skipped], dict[str, Any]]:
    labels, _, _ = used_labels(dataset)
    suffix = options.switches.get("image", "jpg")
    names = {at: text(label_name(labels, at)) for at in range(-1, len(labels))}
    devkit = options.switches.get("coordinates", "cvat") == "devkit"
    lists = picture_lists(dataset, options, rounding=1.0 if devkit else 0.5 * 10**-_DECIMALS)
    total = sum(len(part.frames) for part in lists)
    done = 0
    for subset in subsets_in(lists, options):
        stems: list[str] = []
        for part in lists:
            boxes = _corners(part, devkit)
            heads = _heads(part)
            rows = part.rows.plain()
            for frame, at in part.listed(subset):
                stem = part.stem(frame)
                stems.append(stem)
                content = _picture(part.video, rows, f"{stem}.{suffix}", at, boxes, heads, names)
                out.put(f"Annotations/{stem}.xml", content.encode())
                done += 1
                options.progress(done, total)
        listed = "".join(f"{stem}\n" for stem in stems)
        out.put(f"ImageSets/Main/{subset}.txt", listed.encode("ascii"))
    skipped = _write_label_map(out, labels)
    pictures = write_files(lists, out, options, lambda part, frame, _: f"JPEGImages/{part.stem(frame)}.{suffix}")
    told = {
        "coordinates": "devkit" if devkit else "cvat",
        "origin": 1 if devkit else 0,
        "corners": "pixels from 1, both inclusive, whole" if devkit else "edges from 0, lower right one exclusive",
        "pictures": pictures,
    }
    return skipped, told


def _write_label_map(out: Outlet, labels: list[str]) -> list[Skipped]:
    """CVAT's and Datumaro's list of names; its fields are parted by colons, so names with one cannot be in it."""
    if any(":" in name or "\n" in name or name.startswith("#") for name in labels):
        return [Skipped("labelmap.txt", "A class name has a colon, which parts the fields of that file.")]
    lines = ["# label:color_rgb:parts:actions\n", *(f"{name}:::\n" for name in labels)]
    out.put("labelmap.txt", "".join(lines).encode())
    return []


def _corners(part: PictureList, devkit: bool) -> list[list[str]]:
    """``xmin, ymin, xmax, ymax`` as they are written."""
    video = part.video
    if devkit:
        whole = whole_pixels(part.rows.boxes, video.width, video.height)
        whole[:, :2] += 1
        return [[str(value) for value in row] for row in whole.tolist()]
    boxes = rounded(part.rows.boxes, _DECIMALS, video.width, video.height).tolist()
    return [[f"{value:.{_DECIMALS}f}" for value in row] for row in boxes]


def _heads(part: PictureList) -> list[str]:
    """Attributes that all boxes of a track share."""
    return [
        _attribute("track_id", str(part.first_track + number))
        + _attribute("uid", info.uid)
        + _attribute("state", info.state)
        + _attribute("source", info.source)
        + (_attribute("note", notes_to_text(info.notes)) if info.notes else "")
        for number, info in enumerate(part.rows.tracks, start=1)
    ]


def _attribute(name: str, value: str) -> str:
    return f"<attribute><name>{name}</name><value>{text(value)}</value></attribute>"


def _picture(
    video: DatasetVideo,
    rows: PlainRows,
    name: str,
    at: slice,
    boxes: list[list[str]],
    heads: list[str],
    names: dict[int, str],
) -> str:
    out = [
        f"<annotation><folder/><filename>{text(name)}</filename>\n<source><database>Unknown</database>"
        "<annotation>Unknown</annotation><image>Unknown</image></source>\n"
        f"<size><width>{video.width}</width><height>{video.height}</height><depth>3</depth></size>"
        "<segmented>0</segmented>\n"
    ]
    for k in range(at.start, at.stop):
        xmin, ymin, xmax, ymax = boxes[k]
        score = rows.score[k]
        out.append(
            f"<object><name>{names[rows.label[k]]}</name><truncated>0</truncated>"
            f"<occluded>{rows.occluded[k]:d}</occluded><difficult>{rows.ignore[k]:d}</difficult>\n"
            f"<bndbox><xmin>{xmin}</xmin><ymin>{ymin}</ymin><xmax>{xmax}</xmax><ymax>{ymax}</ymax></bndbox>\n"
            f"<attributes>{_KEY[rows.key[k]]}"
            + (f"<attribute><name>score</name><value>{score:.9g}</value></attribute>" if score == score else "")
            + f"{heads[rows.track[k]]}</attributes></object>\n"
        )
    out.append("</annotation>\n")
    return "".join(out)


class _Object(NamedTuple):
    """One object of a file, without its XML: there can be hundreds of thousands."""

    file: str
    line: int
    frame: int
    corners: tuple[float, ...]
    scale: tuple[float, float]
    label: int
    uid: str
    key: bool
    occluded: bool
    ignore: bool
    score: float


def _read(path: Path, target: ImportTarget) -> Dataset:
    intake = Intake(target)
    files = _files(path)
    if not files and not (path / "ImageSets").is_dir():
        raise refuse(path.name, None, "has no Annotations/*.xml. Export as Pascal VOC again.")
    pictures = PictureNames(path if path.is_dir() else path.parent, target.video)
    found: list[_Object] = []
    about: dict[str, dict[str, Any]] = {}
    for file in files:
        found += _objects(file, pictures, intake, about)
    offset = _offset(path, found, intake)
    if pictures.others:
        intake.skip(f"{pictures.others} pictures", f"They are of another video than {target.video.name}.")
    loose = LooseBoxes(intake, path.name)
    for each in found:
        (x1, y1, x2, y2), (wide, high) = each.corners, each.scale
        edges = ((x1 - offset) * wide, (y1 - offset) * high, x2 * wide, y2 * high)
        given: dict[str, Any] = dict(zip(_GIVEN, (each.file, each.line, *each[7:]), strict=True))
        if not each.uid:
            loose.add(each.frame, edges, each.label, **given)
            continue
        known = each.uid in intake
        if intake.box(each.uid, each.frame, edges, each.label, **given) and not known:
            intake.describe(each.uid, **about[each.uid])
    loose.settle()
    return intake.finish(path.name)


def _files(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    inside = path / "Annotations" if (path / "Annotations").is_dir() else path
    return sorted(inside.rglob("*.xml"))


def _objects(file: Path, pictures: PictureNames, intake: Intake, about: dict[str, dict[str, Any]]) -> Iterator[_Object]:
    """The objects of a file; what they say of a track goes into ``about`` when it first comes."""
    filename, scale, objects = "", (1.0, 1.0), []
    for node in elements(file, "annotation", ("filename", "size", "object")):
        if node.tag == "filename":
            filename = node.text
        elif node.tag == "object":
            objects.append(node)
        else:
            width, height = _real(node, "width", file.name), _real(node, "height", file.name)
            if (width, height) != (0.0, 0.0):
                scale = intake.scale(width, height, file.name, node.line)
    # Tools rename pictures and leave the element; the file's own name comes first.
    frame = pictures.frame(file.name)
    if frame is None and not pictures.is_other(file.name):
        frame = pictures.frame(filename) if filename else None
        if frame is None and not pictures.is_other(filename):
            raise refuse(
                file.name, None, "neither its name nor <filename> has a frame number. Call it frame_000010.xml."
            )
    if frame is None or not objects:
        return
    ordinal = intake.frame(frame, file.name)
    name = sys.intern(file.name)
    for node in objects:
        box = node.child("bndbox")
        if box is None:
            raise refuse(file.name, node.line, "<object> must have <bndbox>. Correct it.")
        corners = tuple(_real(box, name, file.name) for name in ("xmin", "ymin", "xmax", "ymax"))
        yield _object(node, corners, name, ordinal, scale, intake, about)


def _offset(path: Path, found: list[_Object], intake: Intake) -> int:
    """1 where corners count from 1, else 0: as said, as our manifest tells, else by the numbers of all files."""
    asked = intake.target.switches.get("coordinates", "auto")
    zero = next((each for each in found if min(each.corners[:2]) < 1), None)
    if asked == "auto":
        asked = told_by_manifest(path if path.is_dir() else path.parent, "coordinates") or asked
    if asked == "devkit":
        if zero is not None:
            raise refuse(
                zero.file,
                zero.line,
                "a corner below 1 cannot count from 1 as the VOC devkit does. Import with coordinates=cvat.",
            )
        return 1
    if asked == "cvat" or not found:
        return 0
    whole = all(value == int(value) for each in found for value in each.corners if math.isfinite(value))
    if whole and zero is None:
        intake.repair(
            f"{path.name}: corners are whole numbers from 1 on, as in the VOC devkit; xmin and ymin were lowered by 1 "
            "(coordinates=cvat leaves them)."
        )
        return 1
    why = "some have decimals" if not whole else "one lies below 1"
    intake.repair(f"{path.name}: corners were taken as edges from 0, as CVAT writes them, since {why}.")
    return 0


def _real(node: Node, name: str, file: str) -> float:
    child = node.child(name)
    try:
        return float("" if child is None else child.text)
    except ValueError:
        line = node.line if child is None else child.line
        got = "nothing" if child is None else repr(child.text[:40])
        raise refuse(file, line, f"<{name}> of <{node.tag}> must be a number. Got {got}.") from None


def _object(
    node: Node,
    corners: tuple[float, ...],
    file: str,
    frame: int,
    scale: tuple[float, float],
    intake: Intake,
    about: dict[str, dict[str, Any]],
) -> _Object:
    said: dict[str, str] = {}
    attributes = node.child("attributes")
    for entry in attributes.all("attribute") if attributes is not None else ():
        name, value = entry.child("name"), entry.child("value")
        if name is not None and value is not None:
            said[name.text] = value.raw
    number = said.get("score", node.value("score")).strip()
    try:
        score = float(number) if number else math.nan
    except ValueError:
        raise refuse(file, node.line, f"score must be a number. Got {number[:40]!r}.") from None
    track = said.get("track_id", "").strip()
    uid = said.get("uid", "") or (f"track{track}" if track else "")
    if uid and uid not in about:
        about[uid] = {
            "state": said.get("state", "open").strip(),
            "source": said.get("source", "").strip() or "imported",
            "notes": notes_from_text(said.get("note", ""), frame),
        }
    return _Object(
        file,
        node.line,
        frame,
        corners,
        scale,
        intake.label(node.value("name"), file, node.line),
        sys.intern(uid),
        key=said.get("keyframe", "true").strip() in _TRUE,
        occluded=node.value("occluded") in _TRUE or said.get("occluded", "").strip() in _TRUE,
        ignore=node.value("difficult") in _TRUE,
        score=score,
    )


def _sniff(path: Path) -> bool:
    if (
        path.is_dir()
        and not (path / "Annotations").is_dir()
        and any(path.glob("*/*.xml"))
        and not any(path.glob("*.xml"))
    ):
        return False
    for file in _files(path)[:1] if path.is_dir() or path.suffix.lower() == ".xml" else []:
        with file.open("rb") as stream:
            start = stream.read(1 << 14)
        return b"<annotation>" in start or b"<annotation " in start
    return False


FORMAT = Format(
    name="voc",
    title="Pascal VOC",
    summary="An XML file a picture; corners as CVAT writes them or as the VOC devkit does.",
    write=_write,
    read=_read,
    sniff=_sniff,
    export_switches=(
        Switch("coordinates", ("cvat", "devkit"), "Edges from 0 with decimals, or whole pixels from 1."),
        IMAGE_SWITCH,
    ),
    import_switches=(
        Switch("coordinates", ("auto", "cvat", "devkit"), "As for export; auto: by the manifest, else by the numbers."),
        SIZE_SWITCH,
        LINK_SWITCH,
    ),
    docs="voc.md",
)
