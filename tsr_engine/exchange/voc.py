"""Pascal VOC: one XML file a picture.

Two readings of the corners are about. The devkit counts pixels from 1 and both corners belong to the sign; CVAT and
Datumaro write plain edges from 0. The switch ``coordinates`` says which; only the upper left corner differs, by 1.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.beside import told_by_manifest
from tsr_engine.exchange.checks import NO_BOX, SIZE_SWITCH, Intake, refuse
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
from tsr_engine.exchange.small_xml import SMALL, XmlNode, small_elements
from tsr_engine.exchange.spool import Spool, content_of, names_below
from tsr_engine.exchange.whole_pixels import whole_pixels
from tsr_engine.exchange.xml import elements, text
from tsr_engine.io.plain_numbers import real_number

__all__ = ["FORMAT"]

_DECIMALS = 2
_WANTED = ("filename", "size", "object")
_CORNERS = ("xmin", "ymin", "xmax", "ymax")
_TRUE = ("1", "true", "True")
_BOX = "<bndbox><xmin>{0}</xmin><ymin>{0}</ymin><xmax>{0}</xmax><ymax>{0}</ymax></bndbox>"
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
            heads, top = _heads(part), _top(part.video)
            rows = part.rows.plain()
            for frame, at in part.listed(subset):
                stem = part.stem(frame)
                stems.append(stem)
                content = _picture(top, rows, f"{stem}.{suffix}", at, boxes, heads, names)
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


def _corners(part: PictureList, devkit: bool) -> list[str]:
    """The element of each row's corners."""
    video = part.video
    if devkit:
        whole = whole_pixels(part.rows.boxes, video.width, video.height)
        whole[:, :2] += 1
        pattern, rows = _BOX.format("%d"), whole.tolist()
    else:
        pattern = _BOX.format(f"%.{_DECIMALS}f")
        rows = rounded(part.rows.boxes, _DECIMALS, video.width, video.height).tolist()
    return [pattern % tuple(row) for row in rows]


def _top(video: DatasetVideo) -> str:
    """What stands between the name of a picture and its objects."""
    return (
        "</filename>\n<source><database>Unknown</database><annotation>Unknown</annotation><image>Unknown</image>"
        f"</source>\n<size><width>{video.width}</width><height>{video.height}</height><depth>3</depth></size>"
        "<segmented>0</segmented>\n"
    )


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
    top: str,
    rows: PlainRows,
    name: str,
    at: slice,
    boxes: list[str],
    heads: list[str],
    names: dict[int, str],
) -> str:
    out = [f"<annotation><folder/><filename>{text(name)}{top}"]
    for k in range(at.start, at.stop):
        score = rows.score[k]
        said = f"<attribute><name>score</name><value>{score:.9g}</value></attribute>" if score == score else ""
        out.append(
            f"<object><name>{names[rows.label[k]]}</name><truncated>0</truncated>"
            f"<occluded>{rows.occluded[k]:d}</occluded><difficult>{rows.ignore[k]:d}</difficult>\n"
            f"{boxes[k]}\n<attributes>{_KEY[rows.key[k]]}{said}{heads[rows.track[k]]}</attributes></object>\n"
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
    folder, files = _files(path, target.spool)
    if not files and not (path / "ImageSets").is_dir():
        raise refuse(path.name, None, "has no Annotations/*.xml. Export as Pascal VOC again.")
    pictures = PictureNames(path if path.is_dir() else path.parent, target.video)
    found: list[_Object] = []
    about: dict[str, dict[str, Any]] = {}
    for file in files:
        found += _objects(f"{folder}/{file}", pictures, intake, about)
    offset = _offset(path, found, intake)
    if pictures.others:
        intake.skip(f"{pictures.others} pictures", f"They are of another video than {target.video.name}.")
    loose = LooseBoxes(intake, path.name)
    for each in found:
        (x1, y1, x2, y2), (wide, high) = each.corners, each.scale
        edges = ((x1 - offset) * wide, (y1 - offset) * high, x2 * wide, y2 * high)
        uid = each.uid
        known = uid in intake
        # A box without a name waits until all are known.
        take = partial(intake.box, uid) if uid else loose.add
        taken = take(
            each.frame,
            edges,
            each.label,
            file=each.file,
            line=each.line,
            key=each.key,
            occluded=each.occluded,
            ignore=each.ignore,
            score=each.score,
        )
        if uid and taken and not known:
            intake.describe(uid, **about[uid])
    loose.settle()
    return intake.finish(path.name)


def _inside(path: Path) -> Path:
    return path / "Annotations" if (path / "Annotations").is_dir() else path


def _files(path: Path, spool: Spool | None) -> tuple[Path, list[str]]:
    """A folder, and the names of the XML files in it and below, sorted; plain names, since there can be 100,000."""
    if path.is_file():
        return path.parent, [path.name]
    folder = _inside(path)
    return folder, [name for name in names_below(folder, spool) if name.endswith(".xml")]


def _objects(path: str, pictures: PictureNames, intake: Intake, about: dict[str, dict[str, Any]]) -> list[_Object]:
    """The objects of a file; what they say of a track goes into ``about`` when it first comes."""
    name = sys.intern(path.rpartition("/")[2])
    spool = intake.target.spool
    small = small_elements(content_of(path, spool, SMALL + 1), "annotation", _WANTED)
    if small is not None:
        try:
            return list(_objects_in(small, name, pictures, intake, about))
        except ImportFormatError:
            pass  # once more, with the line of every element
    return list(_objects_in(elements(_on_disk(path, spool), "annotation", _WANTED), name, pictures, intake, about))


def _on_disk(path: str, spool: Spool | None) -> Path:
    return Path(path) if spool is None else spool.on_disk(path)


def _objects_in(
    nodes: Iterable[XmlNode], file: str, pictures: PictureNames, intake: Intake, about: dict[str, dict[str, Any]]
) -> Iterator[_Object]:
    filename, scale = "", (1.0, 1.0)
    objects: list[XmlNode] = []
    for node in nodes:
        if node.tag == "filename":
            filename = node.text
        elif node.tag == "object":
            objects.append(node)
        else:
            width, height = _real(node, "width", file), _real(node, "height", file)
            if (width, height) != (0.0, 0.0):
                scale = intake.scale(width, height, file, node.line)
    # Tools rename pictures and leave the element; the file's own name comes first.
    frame = pictures.frame(file)
    if frame is None and not pictures.is_other(file):
        frame = pictures.frame(filename) if filename else None
        if frame is None and not pictures.is_other(filename):
            raise refuse(file, None, "neither its name nor <filename> has a frame number. Call it frame_000010.xml.")
    if frame is None or not objects:
        return
    ordinal = intake.frame(frame, file)
    for node in objects:
        corners = intake.edges(partial(_corners_of, node, file))
        if corners is NO_BOX:
            continue
        yield _object(node, corners, file, ordinal, scale, intake, about)


def _corners_of(node: XmlNode, file: str) -> tuple[float, float, float, float]:
    box = node.child("bndbox")
    if box is None:
        raise refuse(file, node.line, "<object> must have <bndbox>. Correct it.")
    x1, y1, x2, y2 = (_real(box, name, file) for name in _CORNERS)
    return x1, y1, x2, y2


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
    frame: int,
    scale: tuple[float, float],
    intake: Intake,
    about: dict[str, dict[str, Any]],
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
    if path.is_dir():
        file = next(_inside(path).rglob("*.xml"), None)
    else:
        file = path if path.suffix.lower() == ".xml" else None
    if file is None:
        return False
    with file.open("rb") as stream:
        start = stream.read(1 << 14)
    return b"<annotation>" in start or b"<annotation " in start


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
    key_frames=True,
    docs="voc.md",
)
