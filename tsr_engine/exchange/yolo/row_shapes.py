"""Converts rows of YOLO label files to boxes by the number of values after the class.

Four numbers are a box, five a box with a sixth column, more than six a polygon. Six are a triangle or a box with
confidence and track id; this is decided once for all files, since annotations do not mix the two. In a data set with
keypoints the numbers after the box are those. ``save_txt`` of Ultralytics also writes confidence and track id after the
corners of polygons and oriented boxes, and after keypoints.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import repeat
from math import inf

from tsr_engine.exchange.box_rules import Edges
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.reading import rule_error
from tsr_engine.plural import plural

_MIN_COORDINATE, _MAX_COORDINATE = -0.01, 1.01
"""Largest relative coordinate that Ultralytics accepts; the excess is rounding, clipped at the edge."""
_MIN_BOX_VALUES = (_MIN_COORDINATE, _MIN_COORDINATE, -inf, -inf)
"""Smallest value that is read; the validator reports boxes of negative size."""
_ORIENTED_BOX = 8
"""Number of values of the four corners of an oriented box."""
_AMBIGUOUS_COUNT = 6
"""Number of values that are a triangle, or a box with confidence and track id."""
_FAR_APART = 3.0
"""How many times as large as the corners a box and its keypoints are if all are taken for corners."""


@dataclass(frozen=True, slots=True)
class YoloLine:
    """A row as in the file.

    Attributes:
        file: label file, relative to the folder.
        line: from 1.
        frame: ordinal.
        text: the row.
        label: class number.
        values: finite numbers after the class, four or more.
    """

    file: str
    line: int
    frame: int
    text: str
    label: int
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class YoloRow(YoloLine):
    """A box.

    Attributes:
        edges: ``x1, y1, x2, y2`` in px.
        extra_values: columns after the box: none, one to be reported, or confidence and track id.
    """

    edges: Edges
    extra_values: tuple[float, ...]


def rows_to_boxes(lines: Sequence[YoloLine], keypoint_count: int, validator: ImportValidator) -> list[YoloRow]:
    """Return the boxes of all rows in order; report the meaning of rows of six numbers.

    Args:
        lines: rows of all files.
        keypoint_count: how many numbers keypoints have after the box; 0: there are none.
        validator: takes the reports.

    Raises:
        ImportFormatError: a row is neither box nor polygon, rows of six numbers have no common meaning, or rows look
            like keypoints without a shape.
    """
    if keypoint_count:
        lines = [_without_keypoints(line, keypoint_count, validator) for line in lines]
    triangles = _are_triangles(lines, validator)
    polygons = [line for line in lines if len(line.values) > _AMBIGUOUS_COUNT]
    if not keypoint_count:
        _refuse_keypoints(polygons, (validator.target.video.width, validator.target.video.height))
    trailing_count = _trailing_count(polygons)
    if trailing_count == 2:
        count = plural(len(polygons), "row has", "rows have")
        validator.repair(
            f"{polygons[0].file}, line {polygons[0].line}: {count} a confidence and a track id after the corners, as "
            "all end in whole numbers."
        )
    return [_row(line, triangles, trailing_count, validator) for line in lines]


def _without_keypoints(line: YoloLine, count: int, validator: ImportValidator) -> YoloLine:
    """The row without keypoints; a confidence and a track id may follow them."""
    if not 0 <= len(line.values) - 4 - count <= 2:
        return line
    validator.count("Keypoints were left out; their boxes were taken", line.file, line.line)
    return replace(line, values=line.values[:4] + line.values[4 + count :])


def _refuse_keypoints(polygons: Sequence[YoloLine], size: tuple[int, int]) -> None:
    """Refuse rows of which most are boxes with keypoints: as corners of one outline they would lie far apart.

    Raises:
        ImportFormatError: names the shape to write into ``data.yaml``.
    """
    shapes = [_keypoint_shape(line.values, size) for line in polygons]
    counts = Counter(filter(None, shapes))
    if 2 * counts.total() > len(shapes):
        ((shape, _),) = counts.most_common(1)
        line = polygons[shapes.index(shape)]
        rule = (
            f"the numbers look like keypoints after a box. Write their shape into data.yaml, as 'kpt_shape: {shape}'."
        )
        raise rule_error(line.file, line.line, rule)


def _keypoint_shape(values: Sequence[float], size: tuple[int, int]) -> str:
    """The likely ``kpt_shape`` of a row; empty: its numbers can be corners."""
    for trailing_count in range(3):
        numbers = values[: len(values) - trailing_count]
        shapes = []
        for dimensions in (2, 3):
            count, rest = divmod(len(numbers) - 4, dimensions)
            points = zip(numbers[4::dimensions], numbers[5::dimensions], strict=False)
            seen = [point for point in points if point != (0.0, 0.0)]
            if count and not rest:
                shapes.append((_extent([numbers[:2], *seen], size), f"[{count}, {dimensions}]"))
        corners = list(zip(numbers[::2], numbers[1::2], strict=False))
        if shapes and min(shapes)[0] * _FAR_APART < _extent(corners, size):
            return min(shapes)[1]
    return ""


def _extent(points: Sequence[Sequence[float]], size: tuple[int, int]) -> float:
    """The larger side of the upright box around points, px."""
    # A track id is no place in the picture.
    xs, ys = ([min(point[axis], 1.0) for point in points] for axis in (0, 1))
    return max((max(xs) - min(xs)) * size[0], (max(ys) - min(ys)) * size[1])


def _are_triangles(lines: Sequence[YoloLine], validator: ImportValidator) -> bool:
    six = [line for line in lines if len(line.values) == _AMBIGUOUS_COUNT]
    if not six:
        return False
    triangles, reason = _meaning_of_six(six, any(len(line.values) > _AMBIGUOUS_COUNT for line in lines))
    meaning = "triangles" if triangles else "boxes with confidence and track id"
    validator.repair(
        f"{six[0].file}, line {six[0].line}: {plural(len(six), 'row has', 'rows have')} six numbers "
        f"behind the class, taken as {meaning}: {reason}."
    )
    return triangles


def _meaning_of_six(six: Sequence[YoloLine], others_are_longer: bool) -> tuple[bool, str]:
    """Whether rows are triangles, with the reason; ``others_are_longer``: other rows have more corners.

    Raises:
        ImportFormatError: neither meaning is possible.
    """
    # Corners are relative coordinates and track ids whole numbers: only 0 and 1 are both.
    with_fraction = next((line for line in six if line.values[5] != int(line.values[5])), None)
    with_id = next((line for line in six if line.values[5] == int(line.values[5]) and line.values[5] > 1), None)
    if with_fraction is not None and with_id is not None:
        raise rule_error(
            with_id.file,
            with_id.line,
            "six numbers behind the class must be three corners (parts of the picture) or a box, its confidence and a "
            f"track id (a whole number) in all files. Got {with_id.values[5]:g} at the end here, "
            f"{with_fraction.values[5]:g} in {with_fraction.file}, line {with_fraction.line}. Correct the one or the "
            "other.",
        )
    if with_fraction is not None:
        return True, "some end in a fraction, which no track id has"
    if with_id is not None:
        return False, "some end in a whole number above 1, where no corner lies"
    if others_are_longer:
        return True, "all end in 0 or 1, and other rows are polygons"
    counts = Counter((line.file, line.values[5]) for line in {(line.file, line.values): line for line in six}.values())
    if max(counts.values()) > 1:
        return True, "all end in 0 or 1, and one picture has the same twice, which no track has"
    return False, "all end in 0 or 1, and no picture has the same twice"


def _trailing_count(polygons: Sequence[YoloLine]) -> int:
    """How many columns follow the corners of polygons: none, a confidence or a track id, or both."""
    counts = {len(line.values) for line in polygons}
    # Oriented boxes have eight numbers, and outlines have different ones. Rows of another length may have keypoints.
    if len(counts) == 1 and not counts & {_ORIENTED_BOX + 1, _ORIENTED_BOX + 2}:
        return 0
    if polygons and all(count % 2 for count in counts):
        return 1
    ids = Counter((line.file, line.values[-1]) for line in polygons)
    # A corner is a fraction. In a single row 0 or 1 may be one at the picture's edge.
    has_ids = len(polygons) > 1 and all(number == int(number) for _, number in ids) and max(ids.values()) == 1
    return 2 if has_ids else 0


def _row(line: YoloLine, triangles: bool, trailing_count: int, validator: ImportValidator) -> YoloRow:
    values, extra_values = line.values, tuple[float, ...]()
    if len(values) > _AMBIGUOUS_COUNT:
        values, extra_values = values[: len(values) - trailing_count], values[len(values) - trailing_count :]
    polygon = len(values) > _AMBIGUOUS_COUNT or (len(values) == _AMBIGUOUS_COUNT and (triangles or bool(extra_values)))
    if polygon and len(values) % 2:
        raise rule_error(
            line.file,
            line.line,
            f"a polygon must have pairs of x and y after the class. Got {len(values)} numbers. Correct it.",
        )
    for value, minimum in zip(values, repeat(_MIN_COORDINATE) if polygon else _MIN_BOX_VALUES, strict=False):
        if not minimum <= value <= _MAX_COORDINATE:
            hint = "They look like pixels; divide by width and height." if value > 2 else "Correct it."
            raise rule_error(
                line.file, line.line, f"positions and sizes must be parts of the picture, 0 to 1. Got {value:g}. {hint}"
            )
    if polygon:
        validator.count("Polygons were replaced by the upright boxes around them", line.file, line.line)
        xs, ys = values[::2], values[1::2]
        x1, y1, x2, y2 = min(xs), min(ys), max(xs), max(ys)
    else:
        cx, cy, w, h = values[:4]
        x1, y1, x2, y2 = cx - w / 2, cy - h / 2, cx + w / 2, cy + h / 2
        extra_values = values[4:]
    video = validator.target.video
    edges = (x1 * video.width, y1 * video.height, x2 * video.width, y2 * video.height)
    return YoloRow(line.file, line.line, line.frame, line.text, line.label, line.values, edges, extra_values)
