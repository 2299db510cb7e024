"""Shares code between CVAT for video and CVAT for images 1.1: header, labels, attributes, and finding the files."""

from __future__ import annotations

import colorsys
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path

from pydantic import ValidationError

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.added_labels import DeclaredLabel
from tsr_engine.exchange.attributes import original_name, value_as_text, written_name
from tsr_engine.exchange.box_rules import Edges, scaled
from tsr_engine.exchange.dataset import DatasetVideo, Track
from tsr_engine.exchange.file_listing import head_of
from tsr_engine.exchange.frame_rows import TrackInfo
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.labels import UNKNOWN, ClassMap
from tsr_engine.exchange.nearby_manifest import is_named_after
from tsr_engine.exchange.notes import notes_to_text
from tsr_engine.exchange.reading import rule_error
from tsr_engine.exchange.rotated_boxes import bounding_box
from tsr_engine.exchange.split import SUBSETS
from tsr_engine.exchange.video_matching import name_similarity
from tsr_engine.exchange.video_names import safe_stem
from tsr_engine.exchange.xml import Node, attribute, elements, escape_text, number_attribute, quote_attribute
from tsr_engine.io.plain_numbers import parse_real
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.model import Attribute, AttributeValue

SHAPES = frozenset({"polygon", "polyline", "points", "ellipse", "cuboid", "skeleton", "mask"})
"""CVAT's shapes other than boxes."""

_TRACK_ATTRIBUTES = ("uid", "state", "source", "note")
"""Attributes of a whole track."""

_FRAME_ATTRIBUTES = ("score",)
"""Attributes that change from frame to frame."""
_COLOUR = re.compile("#[0-9a-f]{6}")
OPTIONAL_ATTRIBUTES = ("ignore", "frame_label")
"""Attributes of frames that only some exports have."""
TOOL_ATTRIBUTES = frozenset({*_TRACK_ATTRIBUTES, *_FRAME_ATTRIBUTES, *OPTIONAL_ATTRIBUTES})
"""Attributes that this tool writes, which are not a label's."""


def tool_attributes(extra: Iterable[str]) -> list[Attribute]:
    """The attributes of this tool, which each label of a task must declare; ``extra``: further ones of frames."""
    return [
        Attribute(name=name, kind="text", mutable=name not in _TRACK_ATTRIBUTES)
        for name in (*_TRACK_ATTRIBUTES, *_FRAME_ATTRIBUTES, *extra)
    ]


def label_lines(labels: ClassMap, extra: Iterable[str], *, mutable: bool) -> Iterator[str]:
    """The ``<labels>`` element, line by line.

    Args:
        labels: the labels to declare, with their attributes and colours.
        extra: further attributes of this tool that change from frame to frame.
        mutable: whether the task is a video; in tasks of pictures nothing changes.
    """
    own_attributes = tool_attributes(extra)
    declared = [(label.name, label.id, label.colour, label.attributes) for label in labels.labels]
    yield "   <labels>\n"
    for name, index, colour, attributes in [
        *declared,
        *([(UNKNOWN, len(declared), None, ())] if labels.unknown else []),
    ]:
        color = colour or _color(index)
        yield f"    <label><name>{escape_text(name)}</name><color>{color}</color><type>any</type><attributes>\n"
        for each in own_attributes:
            yield _declaration(each, each.name, mutable)
        for each in attributes:
            yield _declaration(each, written_name(each.name), mutable)
        yield "    </attributes></label>\n"
    yield "   </labels>\n"


def _color(index: int) -> str:
    red, green, blue = colorsys.hsv_to_rgb(index * 0.618034 % 1.0, 0.75, 0.95)
    return f"#{round(255 * red):02x}{round(255 * green):02x}{round(255 * blue):02x}"


def _declaration(attribute: Attribute, name: str, mutable: bool) -> str:
    """One attribute of a label; ``values`` of a number are its minimum, maximum and step."""
    values: Iterable[str] = attribute.values
    if attribute.kind == "number" and attribute.low is not None and attribute.high is not None:
        values = (value_as_text(attribute.low), value_as_text(attribute.high), "1")
    default = "" if attribute.default is None else value_as_text(attribute.default)
    changes = "True" if mutable and attribute.mutable else "False"
    lines = "\n".join(map(escape_text, values))
    return (
        f"     <attribute><name>{escape_text(name)}</name><mutable>{changes}</mutable>"
        f"<input_type>{attribute.kind}</input_type>"
        f"<default_value>{escape_text(default)}</default_value><values>{lines}</values></attribute>\n"
    )


def declare_labels(meta: Node, validator: ImportValidator) -> None:
    """Declare to a validator the labels in the ``<meta>`` of a file."""
    for parent in (meta, *meta.children, *(task for node in meta.children for task in _tasks_in(node))):
        labels = parent.child("labels")
        for node in () if labels is None else labels.all("label"):
            attributes = node.child("attributes")
            found = [] if attributes is None else [_attribute(each) for each in attributes.all("attribute")]
            colour = node.value("color").strip().lower()
            validator.declare(
                node.value("name"),
                DeclaredLabel(
                    tuple(each for each in found if each is not None), colour if _COLOUR.fullmatch(colour) else None
                ),
            )


def _tasks_in(node: Node) -> Iterable[Node]:
    tasks = node.child("tasks")
    return () if tasks is None else tasks.all("task")


def _attribute(node: Node) -> Attribute | None:
    """An attribute that a file declares; None: it is the tool's own, or cannot belong to a label."""
    name, kind = node.value("name").strip(), node.value("input_type").strip()
    if name in TOOL_ATTRIBUTES:
        return None
    values = tuple(value for line in node.value("values").split("\n") if (value := line.strip()))
    default = node.value("default_value").strip() or None
    fields: JsonObject = {"name": original_name(name), "mutable": node.value("mutable").strip().lower() == "true"}
    if kind in ("select", "radio"):
        fields |= {"kind": "select", "values": tuple(dict.fromkeys(values)), "default": default}
    elif kind == "checkbox":
        fields |= {"kind": "checkbox", "default": None if default is None else default.lower() == "true"}
    elif kind == "number":
        numbers = [_number(value) for value in (*values[:2], *([default] if default else []))]
        low, high = (*numbers[:2],) if len(values) >= 2 else (None, None)
        fields |= {"kind": "number", "low": low, "high": high, "default": numbers[-1] if default else None}
    else:
        fields |= {"kind": "text", "default": default}
    for overrides in ({}, {"default": None}, {"default": None, "low": None, "high": None}):
        with suppress(ValidationError):
            return Attribute(**(fields | {name: value for name, value in overrides.items() if name in fields}))
    return None


def _number(value: str) -> float | None:
    try:
        return parse_real(value)
    except ValueError:
        return None


def attribute_lines(values: Mapping[str, AttributeValue]) -> str:
    """Attributes of a label as ``<attribute>`` elements."""
    return "".join(attribute_line(written_name(name), value_as_text(value)) for name, value in values.items())


def header_lines(
    *, name: str, size: int, mode: str, subset: str, labels: Iterable[str], video: DatasetVideo | None
) -> Iterator[str]:
    """All lines before the annotations.

    Args:
        name: of the task.
        size: number of frames or pictures.
        mode: ``interpolation`` for videos, ``annotation`` for pictures.
        subset: of the split.
        labels: lines of ``label_lines``.
        video: the only video of the file, which gives size and file name; None: there are several.
    """
    last = max(size - 1, 0)
    yield '<?xml version="1.0" encoding="utf-8"?>\n<annotations>\n <version>1.1</version>\n <meta>\n  <task>\n'
    yield f"   <id>1</id>\n   <name>{escape_text(name)}</name>\n   <size>{size}</size>\n   <mode>{mode}</mode>\n"
    yield "   <overlap>0</overlap>\n   <bugtracker></bugtracker>\n   <created></created>\n   <updated></updated>\n"
    yield f"   <subset>{escape_text(subset)}</subset>\n"
    yield f"   <start_frame>0</start_frame>\n   <stop_frame>{last}</stop_frame>\n"
    yield "   <frame_filter></frame_filter>\n   <segments>\n"
    yield f"    <segment><id>1</id><start>0</start><stop>{last}</stop><url></url></segment>\n   </segments>\n"
    yield "   <owner><username></username><email></email></owner>\n   <assignee></assignee>\n"
    yield from labels
    if video is not None:
        yield f"   <original_size><width>{video.width}</width><height>{video.height}</height></original_size>\n"
        yield f"   <source>{escape_text(video.name)}</source>\n"
    # A fixed date: the same data gives the same bytes.
    yield "  </task>\n  <dumped>1970-01-01 00:00:00+00:00</dumped>\n </meta>\n"


def attribute_line(name: str, value: str) -> str:
    """One ``<attribute>``; empty for an empty value, which means the same as a missing attribute."""
    return f"<attribute name={quote_attribute(name)}>{escape_text(value)}</attribute>" if value else ""


def fact_lines(track: Track | TrackInfo) -> str:
    """State, source and notes of a track as ``<attribute>`` elements."""
    facts = {"state": track.state, "source": track.source, "note": notes_to_text(track.notes)}
    return "".join(attribute_line(name, value) for name, value in facts.items())


def source_of(track: Track | TrackInfo) -> str:
    """CVAT's ``source`` of a track: ``auto`` for the engine's, ``manual`` if a person made or changed it."""
    return "auto" if track.source == "engine" else "manual"


def attributes_of(node: Node) -> dict[str, str]:
    """Attributes of a box by name, with unchanged text."""
    return {child.attrib.get("name", ""): child.raw for child in node.all("attribute")}


def read_flag(node: Node, name: str, file: str, default: str | None = None) -> bool:
    """A flag that is 0 or 1, or False or True as older versions of FiftyOne write it.

    Raises:
        ImportFormatError: the value is another one, or is missing and has no default.
    """
    value = node.attrib.get(name, default) if default is not None else attribute(node, name, file)
    if str(value).lower() not in ("0", "1", "false", "true"):
        raise rule_error(file, node.line, f"{name} of <{node.tag}> must be 0 or 1. Got {str(value)[:40]!r}.")
    return str(value).lower() in ("1", "true")


def read_score(values: Mapping[str, str], file: str, node: Node) -> float:
    """The score among the attributes of a box; NaN: none.

    Raises:
        ImportFormatError: it is not a number.
    """
    value = values.get("score", "").strip()
    try:
        return parse_real(value) if value else math.nan
    except ValueError:
        raise rule_error(file, node.line, f"the attribute score must be a number. Got {value[:40]!r}.") from None


def read_ignore(values: Mapping[str, str], marks: Iterable[str]) -> bool:
    """Whether one of ``marks`` among the attributes of a box says that it is a region to ignore."""
    return any(values.get(name, "").strip().lower() == "true" for name in marks)


def original_scale(size: Node, validator: ImportValidator, file: str) -> tuple[float, float]:
    """Factors from the size in an ``<original_size>`` to the video's.

    Raises:
        ImportFormatError: a side is missing or not a number, or the video has another size.
    """
    try:
        width, height = parse_real(size.value("width")), parse_real(size.value("height"))
    except ValueError:
        raise rule_error(file, size.line, "<original_size> must have a width and a height in px. Correct it.") from None
    return validator.scale(width, height, file, size.line)


def box_edges(node: Node, file: str, validator: ImportValidator, scale: tuple[float, float]) -> Edges:
    """Edges of a ``<box>`` in px, for ``ImportValidator.box``.

    A rotated box is replaced by the upright box around it, which is reported.

    Raises:
        ImportFormatError: an edge is missing or not a number, or the rotation is not finite.
    """

    def read() -> Edges:
        x1, y1, x2, y2 = (number_attribute(node, name, file) for name in ("xtl", "ytl", "xbr", "ybr"))
        degrees = number_attribute(node, "rotation", file) if "rotation" in node.attrib else 0.0
        return scaled(bounding_box((x1, y1, x2, y2), degrees, validator, file, node.line), scale)

    return validator.boxes.edges(read)


def find_files(path: Path, video: DatasetVideo) -> list[tuple[Path, str]]:
    """The XML files about a video, with their names for messages.

    ``path`` is a file, a folder with ``annotations.xml``, or a folder with several files or folders. Of the latter only
    those named after the video or after a subset are taken.

    Raises:
        ImportFormatError: there is none, or the choice is ambiguous.
    """
    if path.is_file():
        return [(path, path.name)]
    if (path / "annotations.xml").is_file():
        return [(path / "annotations.xml", "annotations.xml")]
    # FiftyOne has a folder of labels with a file per video; Datumaro and CVAT have a folder or file per subset.
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


def _is_about(path: Path, name: str, video: DatasetVideo) -> bool:
    if name in SUBSETS or is_named_after(path, video, name) or name_similarity(name, video):
        return True
    video_name, _, subset = name.rpartition("_")
    return subset in SUBSETS and is_named_after(path, video, video_name)


def detect_mode(path: Path) -> str | None:
    """``interpolation`` or ``annotation`` for a file or folder of CVAT, else None.

    A broken file counts as ``interpolation``, so that its reader can report the error.
    """
    if path.is_dir():
        candidates = (
            file for part in ("*.xml", "labels/*.xml", "*/annotations.xml") for file in sorted(path.glob(part))
        )
        files = [path / "annotations.xml", *candidates]
        path = next((file for file in files if file.is_file()), path)
    if not path.is_file():
        return None
    if b"<annotations" not in head_of(path, 1 << 16).replace(b"\0", b""):
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
