"""What CVAT for video and CVAT for images 1.1 have in common: the header, labels, attributes, and finding the files."""

from __future__ import annotations

import colorsys
from collections.abc import Iterable, Iterator
from pathlib import Path

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.beside import is_called
from tsr_engine.exchange.checks import Intake, refuse
from tsr_engine.exchange.dataset import DatasetVideo, Track
from tsr_engine.exchange.names import safe_stem
from tsr_engine.exchange.split import SUBSETS
from tsr_engine.exchange.subject import likeness
from tsr_engine.exchange.turned import upright
from tsr_engine.exchange.xml import Node, attribute, elements, number, quoted, text

__all__ = [
    "SHAPES",
    "attribute_line",
    "attributes_of",
    "box_edges",
    "find_files",
    "flag",
    "header",
    "label_lines",
    "sniff_mode",
    "source_of",
]

SHAPES = frozenset({"polygon", "polyline", "points", "ellipse", "cuboid", "skeleton", "mask"})
"""Shapes of CVAT that are no boxes."""

_FIXED = ("uid", "state", "source", "note")
"""Attributes that hold for a whole track."""

_CHANGING = ("score",)
"""Attributes that change from frame to frame."""


def label_lines(labels: Iterable[str], extra: Iterable[str], *, mutable: bool) -> Iterator[str]:
    """The ``<labels>`` element, line by line.

    Args:
        labels: class names.
        extra: further attributes that change from frame to frame.
        mutable: the task is a video; in tasks of pictures nothing changes.
    """
    yield "   <labels>\n"
    for place, name in enumerate(labels):
        red, green, blue = colorsys.hsv_to_rgb(place * 0.618034 % 1.0, 0.75, 0.95)
        color = f"#{round(255 * red):02x}{round(255 * green):02x}{round(255 * blue):02x}"
        yield f"    <label><name>{text(name)}</name><color>{color}</color><type>any</type><attributes>\n"
        for kind in (*_FIXED, *_CHANGING, *extra):
            changes = "True" if mutable and kind not in _FIXED else "False"
            yield (
                f"     <attribute><name>{kind}</name><mutable>{changes}</mutable><input_type>text</input_type>"
                "<default_value></default_value><values></values></attribute>\n"
            )
        yield "    </attributes></label>\n"
    yield "   </labels>\n"


def header(
    *, name: str, size: int, mode: str, subset: str, labels: Iterable[str], video: DatasetVideo | None
) -> Iterator[str]:
    """Everything before the annotations, line by line.

    Args:
        name: of the task.
        size: number of frames or pictures.
        mode: ``interpolation`` for videos, ``annotation`` for pictures.
        subset: of the split.
        labels: lines of ``label_lines``.
        video: where all is about one; gives size and file name.
    """
    last = max(size - 1, 0)
    yield '<?xml version="1.0" encoding="utf-8"?>\n<annotations>\n <version>1.1</version>\n <meta>\n  <task>\n'
    yield f"   <id>1</id>\n   <name>{text(name)}</name>\n   <size>{size}</size>\n   <mode>{mode}</mode>\n"
    yield "   <overlap>0</overlap>\n   <bugtracker></bugtracker>\n   <created></created>\n   <updated></updated>\n"
    yield f"   <subset>{text(subset)}</subset>\n   <start_frame>0</start_frame>\n   <stop_frame>{last}</stop_frame>\n"
    yield "   <frame_filter></frame_filter>\n   <segments>\n"
    yield f"    <segment><id>1</id><start>0</start><stop>{last}</stop><url></url></segment>\n   </segments>\n"
    yield "   <owner><username></username><email></email></owner>\n   <assignee></assignee>\n"
    yield from labels
    if video is not None:
        yield f"   <original_size><width>{video.width}</width><height>{video.height}</height></original_size>\n"
        yield f"   <source>{text(video.name)}</source>\n"
    # A fixed date: the same data gives the same bytes.
    yield "  </task>\n  <dumped>1970-01-01 00:00:00+00:00</dumped>\n </meta>\n"


def attribute_line(name: str, value: str) -> str:
    """One ``<attribute>``; nothing for an empty value, which is what a missing one means."""
    return f"<attribute name={quoted(name)}>{text(value)}</attribute>" if value else ""


def source_of(track: Track) -> str:
    """CVAT's ``source`` of a track: ``auto`` for the engine's, ``manual`` where a person had a hand in it."""
    return "auto" if track.source == "engine" else "manual"


def attributes_of(node: Node) -> dict[str, str]:
    """Attributes of a box by name; their text as it is."""
    return {child.attrib.get("name", ""): child.raw for child in node.all("attribute")}


def flag(node: Node, name: str, file: str, default: str | None = None) -> bool:
    """A flag that is written 0 or 1, or as older versions of FiftyOne write it, False or True.

    Raises:
        ImportFormatError: another value, or missing without default.
    """
    value = node.attrib.get(name, default) if default is not None else attribute(node, name, file)
    if str(value).lower() not in ("0", "1", "false", "true"):
        raise refuse(file, node.line, f"{name} of <{node.tag}> must be 0 or 1. Got {str(value)[:40]!r}.")
    return str(value).lower() in ("1", "true")


def box_edges(node: Node, file: str, intake: Intake, scale: tuple[float, float]) -> tuple[float, float, float, float]:
    """Edges of a ``<box>`` in px, for ``Intake.box``; a turned box becomes the upright one around it, with a sentence.

    Raises:
        ImportFormatError: an edge is missing or no number, or the turn is not finite.
    """
    return intake.edges(lambda: _edges(node, file, intake, scale))


def _edges(node: Node, file: str, intake: Intake, scale: tuple[float, float]) -> tuple[float, float, float, float]:
    x1, y1, x2, y2 = (number(node, name, file) for name in ("xtl", "ytl", "xbr", "ybr"))
    if "rotation" in node.attrib:
        x1, y1, x2, y2 = upright((x1, y1, x2, y2), number(node, "rotation", file), intake, file, node.line)
    return x1 * scale[0], y1 * scale[1], x2 * scale[0], y2 * scale[1]


def find_files(path: Path, video: DatasetVideo) -> list[tuple[Path, str]]:
    """The XML files about a video, with their names for messages.

    A file is itself; a folder has ``annotations.xml``, or several files or folders, of which those that are named after
    the video or after a subset count.

    Raises:
        ImportFormatError: there is none, or it is not clear which one.
    """
    if path.is_file():
        return [(path, path.name)]
    if (path / "annotations.xml").is_file():
        return [(path / "annotations.xml", "annotations.xml")]
    # FiftyOne has a folder of labels with a file for each video; Datumaro and CVAT a folder or file for each subset.
    for pattern in ("*.xml", "labels/*.xml", "*/annotations.xml"):
        found = sorted(file for file in path.glob(pattern) if file.is_file())
        folders = pattern.startswith("*/")
        names = [file.parent.name if folders else file.stem for file in found]
        parts = [
            file for file, name in zip(found, names, strict=True) if len(found) == 1 or _is_about(path, name, video)
        ]
        if found and not parts:
            raise ImportFormatError(
                f"{path.name}: has annotations of several videos ({', '.join(names[:8])}), none in a "
                f"{'folder' if folders else 'file'} called {safe_stem(video.name)}. Import one of them."
            )
        if parts:
            return [(part, part.relative_to(path).as_posix()) for part in parts]
    raise ImportFormatError(f"{path.name}: has no annotations.xml. Export as CVAT 1.1 again.")


def _is_about(path: Path, called: str, video: DatasetVideo) -> bool:
    if called in SUBSETS or is_called(path, video, called) or likeness(called, video):
        return True
    name, _, subset = called.rpartition("_")
    return subset in SUBSETS and is_called(path, video, name)


def sniff_mode(path: Path) -> str | None:
    """``interpolation`` or ``annotation`` of a file or folder; None: not of CVAT.

    A broken file counts as ``interpolation``, so that its reader can say what is wrong with it.
    """
    if path.is_dir():
        below = (file for part in ("*.xml", "labels/*.xml", "*/annotations.xml") for file in sorted(path.glob(part)))
        files = [path / "annotations.xml", *below]
        path = next((file for file in files if file.is_file()), path)
    if not path.is_file():
        return None
    with path.open("rb") as stream:
        if b"<annotations" not in stream.read(1 << 16).replace(b"\0", b""):
            return None
    mode = "interpolation"
    try:
        for node in elements(path, "annotations", ("mode", "track", "image")):
            if node.tag == "mode":
                mode = node.text or mode
            else:
                return "annotation" if node.tag == "image" else "interpolation"
    except ImportFormatError:
        return "interpolation"
    return mode if mode in ("interpolation", "annotation") else None
