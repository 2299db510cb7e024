"""Reads tables of boxes strictly, one row for each track and frame; an error names the first line that breaks a rule.

A frame of 1.9, an inverted box or a sign twice in one frame are mistakes in the table. A lenient reader would give
wrong figures that nobody notices.
"""

from __future__ import annotations

import csv
from array import array
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.io.plain_numbers import parse_real
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT
from tsr_engine.records import FloatArray

TRUTH_COLUMNS: Final = ("frame", "track_id", "x1", "y1", "x2", "y2", "class_id", "visibility", "ignore")
RESULT_COLUMNS: Final = ("frame", "track_id", "x1", "y1", "x2", "y2", "class_id", "score", "source")
MOT_COLUMNS: Final = ("frame", "id", "left", "top", "width", "height", "flag", "class_id", "visibility")
MAX_COORDINATE: Final = 1e5
"""Largest absolute coordinate of a box, px."""
_MAX_FRAMES: Final = 2**31
_MAX_INTEGER: Final = 2**53
"""Whole numbers below this are exact as floats."""

BoolArray = NDArray[np.bool_]
Columns = Mapping[str, FloatArray]
Rules = Callable[[Columns], list["_Rule"]]


class RowError(Exception):
    """A line that breaks a rule.

    Attributes:
        line: number of the line in the file, from 1.
        rule: what was expected and what was got; without a full stop.
    """

    def __init__(self, line: int, rule: str) -> None:
        super().__init__(f"line {line}: {rule}")
        self.line, self.rule = line, rule


@dataclass(frozen=True, slots=True)
class _Rule:
    """A rule for all rows.

    Attributes:
        is_broken: shape (n,): whether each row breaks the rule.
        text: the rule.
        columns: columns whose values the error reports.
    """

    is_broken: BoolArray
    text: str
    columns: tuple[str, ...]


def read_truth_table(content: bytes, frames: int | None = None, max_rows: int | None = None) -> FloatArray:
    """Read ground truth.

    Args:
        content: UTF-8 text; the first line names ``TRUTH_COLUMNS``, in any order; other columns are ignored.
        frames: number of frames of the video; unset: unknown, so that any frame is valid.
        max_rows: largest number of rows; unset: no limit.

    Returns:
        Shape (n, 9), columns as in ``TRUTH_COLUMNS``, in the order of the file.

    Raises:
        RowError: a line breaks a rule; names the first such line.
    """

    def rules(column: Columns) -> list[_Rule]:
        visibility, ignore = column["visibility"], column["ignore"]
        return [
            *_box_rules(column, frames),
            _integer_rule(column, "class_id", -1, CLASS_COUNT),
            _Rule((visibility < 0) | (visibility > 1), "visibility must lie in 0 to 1", ("visibility",)),
            _Rule((ignore != 0) & (ignore != 1), "ignore must be 0 or 1", ("ignore",)),
        ]

    return _read(content, TRUTH_COLUMNS, rules, ("frame", "track_id"), max_rows=max_rows)[0]


def read_result_table(content: bytes) -> tuple[FloatArray, tuple[str, ...]]:
    """Read result rows of ``tsr track`` or ``tsr replay``, or of another tracker.

    Args:
        content: UTF-8 text; the first line names ``RESULT_COLUMNS``, in any order; other columns are ignored.

    Returns:
        Shape (n, 8), the numeric columns of ``RESULT_COLUMNS``; and the source of each row.

    Raises:
        RowError: a line breaks a rule; names the first such line.
    """

    def rules(column: Columns) -> list[_Rule]:
        return [*_box_rules(column, None), _integer_rule(column, "class_id", -1, _MAX_INTEGER)]

    return _read(content, RESULT_COLUMNS, rules, ("frame", "track_id"), text_column="source")


def read_mot_table(content: bytes) -> FloatArray:
    """Read MOTChallenge rows without a header; further columns are ignored.

    Args:
        content: UTF-8 text.

    Returns:
        Shape (n, 9), columns as in ``MOT_COLUMNS``, frames from 1 as in the file.

    Raises:
        RowError: a line breaks a rule; names the first such line.
    """

    def rules(column: Columns) -> list[_Rule]:
        visibility, flag = column["visibility"], column["flag"]
        far = np.max([np.abs(column[name]) for name in ("left", "top", "width", "height")], axis=0) > MAX_COORDINATE
        return [
            _integer_rule(column, "frame", 1, _MAX_FRAMES),
            _integer_rule(column, "id", 0, _MAX_INTEGER),
            _Rule(
                ~((column["width"] > 0) & (column["height"] > 0)),
                "width and height must be above 0",
                ("width", "height"),
            ),
            _Rule(far, f"the edges of a box lie within {MAX_COORDINATE:.0f} px", ("left", "top", "width", "height")),
            _Rule((flag != 0) & (flag != 1), "flag must be 0 or 1", ("flag",)),
            _integer_rule(column, "class_id", -1, _MAX_INTEGER),
            _Rule((visibility < 0) | (visibility > 1), "visibility must lie in 0 to 1", ("visibility",)),
        ]

    return _read(content, MOT_COLUMNS, rules, ("frame", "id"), header=False)[0]


def _box_rules(column: Columns, frames: int | None) -> list[_Rule]:
    x1, y1, x2, y2 = (column[name] for name in ("x1", "y1", "x2", "y2"))
    corners = ("x1", "y1", "x2", "y2")
    far = np.max(np.abs([x1, y1, x2, y2]), axis=0) > MAX_COORDINATE
    return [
        _integer_rule(column, "frame", 0, _MAX_FRAMES if frames is None else frames),
        _integer_rule(column, "track_id", 0, _MAX_INTEGER),
        _Rule((x1 >= x2) | (y1 >= y2), "a box needs x1 < x2 and y1 < y2", corners),
        _Rule(far, f"the edges of a box lie within {MAX_COORDINATE:.0f} px", corners),
    ]


def _integer_rule(column: Columns, name: str, minimum: int, end: int) -> _Rule:
    values = column[name]
    is_broken = (values != np.floor(values)) | (values < minimum) | (values >= end)
    upper = "on" if end == _MAX_INTEGER else f"to {end - 1}"
    return _Rule(is_broken, f"{name} must be a whole number from {minimum} {upper}", (name,))


def _finite_rules(column: Columns) -> list[_Rule]:
    return [_Rule(~np.isfinite(values), f"{name} must be finite", (name,)) for name, values in column.items()]


def _read(
    content: bytes,
    columns: Sequence[str],
    rules: Rules,
    key: tuple[str, str],
    *,
    header: bool = True,
    text_column: str = "",
    max_rows: int | None = None,
) -> tuple[FloatArray, tuple[str, ...]]:
    """Read the numeric columns of a table and its column of words.

    Reading ends at a line whose values are not numbers. The rows before it are still checked, so that the error names
    the first bad line.
    """
    lines = _lines(content)
    indices, width = _column_indices(lines, columns) if header else (list(range(len(columns))), None)
    numeric = [(name, index) for name, index in zip(columns, indices, strict=True) if name != text_column]
    table, texts, numbers = array("d"), [], array("q")
    failure: RowError | None = None
    for number, line in islice(enumerate(lines, start=1), int(header), None):
        if not line.strip():
            continue
        if max_rows is not None and len(numbers) == max_rows:
            failure = RowError(number, f"a file has at most {max_rows} rows")
            break
        try:
            cells = _cells(number, line, width, len(columns))
            table.extend([_number(number, name, cells[index]) for name, index in numeric])
        except RowError as error:
            failure = error
            break
        if text_column:
            texts.append(cells[indices[-1]])
        numbers.append(number)
    values = np.array(table).reshape(-1, len(numeric))
    by_name = {name: values[:, k] for k, (name, _) in enumerate(numeric)}
    _check(by_name, [*_finite_rules(by_name), *rules(by_name)], key, np.array(numbers))
    if failure is not None:
        raise failure
    return values, tuple(texts)


def _lines(content: bytes) -> list[str]:
    try:
        return content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise RowError(content[: error.start].count(b"\n") + 1, "the text must be UTF-8") from None


def _column_indices(lines: Sequence[str], columns: Sequence[str]) -> tuple[list[int], int]:
    """The index of each column, and the number of columns in the file."""
    found = _split(1, lines[0]) if lines else []
    missing = [name for name in columns if found.count(name) != 1]
    if missing:
        got = f"{lines[0][:120]!r}" if lines else "an empty file"
        raise RowError(1, f"the header must name {','.join(columns)}, each once, got {got}")
    return [found.index(name) for name in columns], len(found)


def _split(number: int, line: str) -> list[str]:
    try:
        return next(csv.reader([line]), [])
    except csv.Error as error:
        raise RowError(number, f"a line must be values between commas ({error})") from None


def _cells(number: int, line: str, width: int | None, min_width: int) -> list[str]:
    cells = _split(number, line)
    if len(cells) < min_width if width is None else len(cells) != width:
        expected = f"at least {min_width}" if width is None else str(width)
        raise RowError(number, f"a row has {expected} values, got {len(cells)}")
    return cells


def _number(number: int, name: str, cell: str) -> float:
    try:
        return parse_real(cell)
    except ValueError:
        raise RowError(number, f"{name} must be a number, got {cell[:40]!r}") from None


def _check(column: Columns, rules: Sequence[_Rule], key: tuple[str, str], numbers: NDArray[np.int64]) -> None:
    """Raise for the first row that breaks a rule, with the first rule that it breaks."""
    found = [(int(np.argmax(rule.is_broken)), order) for order, rule in enumerate(rules) if rule.is_broken.any()]
    row, order = min(found, default=(len(numbers), 0))
    duplicate, original = _first_duplicate(column[key[0]][:row], column[key[1]][:row])
    if duplicate is not None:
        raise RowError(
            int(numbers[duplicate]),
            f"a track has one box a frame; line {numbers[original]} has this frame and track already",
        )
    if found:
        rule = rules[order]
        got = ", ".join(f"{column[name][row]:.12g}" for name in rule.columns)
        raise RowError(int(numbers[row]), f"{rule.text}, got {got}")


def _first_duplicate(frame: FloatArray, track: FloatArray) -> tuple[int | None, int]:
    """The first row that repeats frame and track of an earlier row, and that earlier row."""
    order = np.lexsort((np.arange(len(frame)), track, frame))
    same = (np.diff(frame[order]) == 0) & (np.diff(track[order]) == 0)
    if not same.any():
        return None, -1
    duplicate = int(order[1:][same].min())
    return duplicate, int(np.flatnonzero((frame == frame[duplicate]) & (track == track[duplicate]))[0])
