"""Lists the column names in other tools' tables and the keys of their JSON rows.

The list has the names of supervision's ``CSVSink`` and ``JSONSink``, Ultralytics' ``to_csv``, ``to_json`` and
``to_df``, MOTChallenge's, and names that people write. Names are compared without case, with ``_`` for spaces, dots and
dashes.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

from tsr_engine.exchange.box_rules import Edges
from tsr_engine.exchange.video_matching import is_video
from tsr_engine.io.plain_numbers import parse_real

COLUMN_NAMES: dict[str, tuple[str, ...]] = {
    "frame": (
        "frame", "frame_id", "frame_number", "frame_index", "frame_idx", "frame_no", "frame_num", "frame_nr",
        "frameid", "framenumber", "frameindex",
    ),
    "track": (
        "track_id", "tracker_id", "track", "trackid", "trackerid", "id", "object_id", "obj_id", "tid", "instance_id",
    ),
    "uid": ("uid",),
    "x1": ("x1", "xmin", "x_min", "left", "xtl", "box_x1", "bbox_x1", "box_xmin", "bbox_xmin", "bbox_x_min"),
    "y1": ("y1", "ymin", "y_min", "top", "ytl", "box_y1", "bbox_y1", "box_ymin", "bbox_ymin", "bbox_y_min"),
    "x2": ("x2", "xmax", "x_max", "right", "xbr", "box_x2", "bbox_x2", "box_xmax", "bbox_xmax", "bbox_x_max"),
    "y2": ("y2", "ymax", "y_max", "bottom", "ybr", "box_y2", "bbox_y2", "box_ymax", "bbox_ymax", "bbox_y_max"),
    "box": ("box", "xyxy"),
    "bbox": ("bbox", "xywh"),
    "score": ("score", "confidence", "conf"),
    "source": ("source",),
    "visibility": ("visibility",),
    "occluded": ("occluded",),
    "ignore": ("ignore",),
    "key": ("key", "keyframe"),
    "state": ("state",),
    "note": ("note",),
    "attributes": ("attributes",),
    "video": ("video", "video_name", "video_file", "video_path", "video_id", "sequence"),
}  # fmt: skip
CLASS_COLUMNS = ("label", "class_name", "classname", "class", "category", "category_name", "label_name", "name",
           "class_id", "classid", "category_id", "label_id", "cls", "cls_id")  # fmt: skip
"""Columns of classes; a text goes before a number, then the order decides."""
_IDS = frozenset({"class_id", "classid", "category_id", "label_id", "cls", "cls_id"})
"""Class columns of numbers; a number in another class column may be a name, such as a speed limit."""
PICTURE_COLUMNS = ("filename", "file_name", "image", "image_name", "image_path", "image_id", "imageid", "img", "path")
"""Columns in which other tables name pictures instead of frames."""
MISSING_VALUES = frozenset({"", "nan", "none", "null"})
"""Cells that mean a missing value."""
MOT_COLUMNS = ("bb_left", "bb_top", "bb_width", "bb_height")
"""MOTChallenge's names; its ``x,y,z`` beside them are positions in space."""
_SIZED_COLUMNS = (
    ("x", "y", "w", "h"),
    ("left", "top", "width", "height"),
    *((f"{box}_x", f"{box}_y", f"{box}_w", f"{box}_h") for box in ("box", "bbox")),
    *((f"{box}_left", f"{box}_top", f"{box}_width", f"{box}_height") for box in ("box", "bbox")),
)
"""Names that belong together."""
_CORNERS = (("x", "y"), ("bb_left", "bb_top"), *zip(COLUMN_NAMES["x1"], COLUMN_NAMES["y1"], strict=True))
_SIZES = (("w", "h"), ("width", "height"), ("bb_width", "bb_height"))
_CENTRES = (("x_center", "y_center"), ("center_x", "center_y"), ("xcenter", "ycenter"), ("cx", "cy"), ("xc", "yc"))
_OTHER = re.compile(r"[^a-z0-9]+")
_CORNER_COLUMNS = ("x1", "y1", "x2", "y2")
_EDGES = frozenset({*_CORNER_COLUMNS, "x", "y", "cx", "cy", "w", "h"})


@dataclass(frozen=True, slots=True)
class Columns:
    """The meaning of each column of a table.

    Attributes:
        named: meaning -> column. A box has ``x1`` to ``y2``, or ``x``, ``y``, ``w``, ``h``, with ``cx``, ``cy`` for the
            centre, or all in ``box`` or ``bbox``.
        classes: columns that may hold a class, in order of preference.
        frames: further columns of frames.
        mot: whether the names are MOTChallenge's, whose frames count from 1.
        is_own_table: whether this tool wrote the table: classes are its numbers, frames count from 0.
    """

    named: Mapping[str, str]
    classes: tuple[str, ...]
    frames: tuple[str, ...]
    mot: bool
    is_own_table: bool

    @property
    def box(self) -> bool:
        """Whether the columns include a box."""
        return bool({"x1", "x", "cx", "box", "bbox"} & set(self.named))


@lru_cache(maxsize=4096)
def normalized(name: str) -> str:
    """A name in the form used for comparison."""
    return _OTHER.sub("_", name.strip().lower()).strip("_")


def is_id_column(name: str) -> bool:
    """Whether a class column holds numbers, by its name."""
    return normalized(name) in _IDS


def find_columns(names: Iterable[str]) -> Columns:
    """Find the meaning of column names.

    Raises:
        ValueError: there is more than one set of box columns; names them.
    """
    column_by_name = {normalized(name): name for name in reversed(list(names))}
    found = {
        meaning: column_by_name[column]
        for meaning, known in COLUMN_NAMES.items()
        if (column := next((each for each in known if each in column_by_name), None)) is not None
    }
    mot = column_by_name.keys() >= set(MOT_COLUMNS)
    edges = set(found) >= set(_CORNER_COLUMNS)
    sized = MOT_COLUMNS if mot else None if edges else _find_sized_columns(column_by_name)
    if sized is not None or not edges:
        for name in _CORNER_COLUMNS:
            found.pop(name, None)
    if sized is not None:
        corner = ("cx", "cy") if sized[:2] in _CENTRES else ("x", "y")
        found.update(zip((*corner, "w", "h"), (column_by_name[name] for name in sized), strict=True))
    if sized is not None or edges:
        for name in ("box", "bbox"):
            found.pop(name, None)
    classes = tuple(column_by_name[name] for name in CLASS_COLUMNS if name in column_by_name)
    frames = tuple(column_by_name[name] for name in COLUMN_NAMES["frame"] if name in column_by_name)[1:]
    is_own_table = {"track", "source"} <= set(found) or {"track", "visibility", "ignore"} <= set(found)
    return Columns(
        found,
        classes,
        frames,
        sized is not None and sized[0] == MOT_COLUMNS[0],
        is_own_table and "class_id" in column_by_name,
    )


def with_video(columns: Columns, cells: Mapping[str, str]) -> Columns:
    """The columns with that of the video, if a column that may name pictures names a video in the given row."""
    found = next(
        (name for name in cells if normalized(name) in (*PICTURE_COLUMNS, "source") and is_video(cells[name])), None
    )
    # Tables of this tool name no video in a row.
    return columns if found is None else replace(columns, named={**columns.named, "video": found}, is_own_table=False)


def _find_sized_columns(column_by_name: Mapping[str, str]) -> tuple[str, ...] | None:
    """Columns of a corner or centre with a width and a height; None: there are none."""
    matching = [names for names in _SIZED_COLUMNS if column_by_name.keys() >= set(names)]
    pairs = [(*corner, *size) for corner in _CORNERS for size in _SIZES]
    centred = [(*centre, *size) for centre in _CENTRES for size in _SIZES]
    found = matching or [names for names in (*pairs, *centred) if column_by_name.keys() >= set(names)]
    if len(found) > 1:
        raise ValueError(" or ".join(",".join(names) for names in found[:3]))
    return found[0] if found else None


def class_of_cells(values: Iterable[str]) -> str:
    """The class of a row: the first text in its class columns, else the first number."""
    given = [value for value in values if value.strip().lower() not in MISSING_VALUES]
    return next((value for value in given if not _is_number(value)), given[0] if given else "")


def edges_of(value: object, *, sized: bool) -> Edges | None:
    """The edges of a box given as a list, an object or their text; None: it is not a box.

    Args:
        value: ``[x1, y1, x2, y2]``, or with ``sized`` ``[x, y, w, h]``; an object has the names of columns. Corners
            ``x3, y3, x4, y4`` of a rotated box are used too.
        sized: whether four numbers without names are a corner and a size.
    """
    if isinstance(value, str):
        value = _parsed(value)
    if isinstance(value, list):
        if len(value) != 4 or not all(type(each) in (int, float) for each in value):
            return None
        a, b, c, d = (_float(each) for each in value)
        return (a, b, a + c, b + d) if sized else (a, b, c, d)
    if not isinstance(value, dict):
        return None
    try:
        named = find_columns(value).named
    except ValueError:
        return None
    value = {name: _float(each) for name, each in value.items() if _is_number(each)}
    if not {named[name] for name in _EDGES & named.keys()} <= value.keys():
        return None
    return _edges({name: value[column] for name, column in named.items() if name in _EDGES}, value)


def _edges(numbers: Mapping[str, float], value: Mapping[str, float]) -> Edges | None:
    if numbers.keys() >= set(_CORNER_COLUMNS):
        corners = [[value[name] for k in "1234" if (name := f"{axis}{k}") in value] for axis in "xy"]
        xs, ys = corners
        if len(xs) == len(ys) == 4:
            return min(xs), min(ys), max(xs), max(ys)
        return numbers["x1"], numbers["y1"], numbers["x2"], numbers["y2"]
    if "w" not in numbers or "h" not in numbers:
        return None
    w, h = numbers["w"], numbers["h"]
    if "cx" in numbers:
        return numbers["cx"] - w / 2, numbers["cy"] - h / 2, numbers["cx"] + w / 2, numbers["cy"] + h / 2
    return numbers["x"], numbers["y"], numbers["x"] + w, numbers["y"] + h


def _parsed(text: str) -> object:
    """The list or object in a cell: JSON, Python, or four numbers in any brackets."""
    text = text.strip()
    if ":" not in text:
        text = "[" + ",".join(text.strip("[](){}").replace(",", " ").split()) + "]"
    try:
        return json.loads(text.replace("'", '"'))
    except (ValueError, RecursionError):
        return None


def _float(value: float | str) -> float:
    try:
        return parse_real(value) if isinstance(value, str) else float(value)
    except OverflowError:
        return math.inf


def _is_number(value: object) -> bool:
    if isinstance(value, str):
        try:
            parse_real(value.strip())
        except ValueError:
            return False
        return True
    return type(value) in (int, float)
