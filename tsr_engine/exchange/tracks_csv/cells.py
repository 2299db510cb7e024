"""Reads the cells of a row: numbers, flags, a box, the name of a track, a score."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import get_args

from tsr_engine.exchange.box_rules import Edges, check_pixels
from tsr_engine.exchange.ids import WHOLE_ID
from tsr_engine.exchange.reading import rule_error
from tsr_engine.exchange.table_columns import edges_of
from tsr_engine.io.plain_numbers import parse_real
from tsr_engine.records import Source

_LOG_ODDS_SOURCES = frozenset(get_args(Source))
"""Sources in rows of ``tsr track --csv``."""


def differ(one: str, other: str) -> bool:
    """Whether two cells are different numbers."""
    try:
        return parse_real(one) != parse_real(other)
    except ValueError:
        return False


def read_edges(cells: Mapping[str, str], is_own_table: bool, file: str, line: int) -> Edges:
    """Read the edges of the box, px.

    Raises:
        ImportFormatError: a cell is not a number, or the box of another tool's table lies within the first pixel.
    """
    if "x1" in cells:
        x1, y1, x2, y2 = (read_number(cells, name, file, line) for name in ("x1", "y1", "x2", "y2"))
        edges = (x1, y1, x2, y2)
    elif "w" in cells:
        centred = "cx" in cells
        x, y = (read_number(cells, name, file, line) for name in (("cx", "cy") if centred else ("x", "y")))
        w, h = (read_number(cells, name, file, line) for name in ("w", "h"))
        x, y = (x - w / 2, y - h / 2) if centred else (x, y)
        edges = (x, y, x + w, y + h)
    else:
        name = "box" if "box" in cells else "bbox"
        found = edges_of(cells[name], sized=name == "bbox")
        if found is None:
            raise rule_error(
                file, line, f"{name} must be four numbers, with or without names. Got {cells[name][:60]!r}."
            )
        edges = found
    return edges if is_own_table else check_pixels(edges, file, line)


def read_uid(cells: Mapping[str, str], file: str, line: int) -> str:
    """Read the track's name; empty: none."""
    if cells.get("uid"):
        return cells["uid"]
    cell = cells.get("track", "")
    if WHOLE_ID.fullmatch(cell):
        # A float would make one id of several above 2**53.
        return str(int(cell))
    try:
        number = parse_real(cell) if cell else -1.0
    except ValueError:
        return cell
    if not math.isfinite(number) or number != int(number):
        raise rule_error(file, line, f"track_id must be a whole number or a name. Got {cell[:40]!r}.")
    return str(int(number)) if number >= 0 else ""


def read_score(cells: Mapping[str, str], file: str, line: int) -> float:
    """Read a score in [0, 1]; NaN: none. The table of `tsr track`, recognised by its sources, has log-odds."""
    if not cells.get("score"):
        return math.nan
    value = read_number(cells, "score", file, line)
    if cells.get("source") in _LOG_ODDS_SOURCES:
        return 1.0 / (1.0 + math.exp(-min(max(value, -500.0), 500.0)))
    return value


def read_flag(cells: Mapping[str, str], name: str, file: str, line: int, default: bool) -> bool:
    """Read 0 or 1; an empty cell means ``default``."""
    cell = cells.get(name, "").lower()
    if not cell:
        return default
    if cell not in ("0", "1", "true", "false", "0.0", "1.0"):
        raise rule_error(file, line, f"{name} must be 0 or 1. Got {cell[:40]!r}.")
    return cell in ("1", "true", "1.0")


def read_number(cells: Mapping[str, str], name: str, file: str, line: int) -> float:
    """Read a finite number."""
    cell = cells[name]
    try:
        value = parse_real(cell)
    except ValueError:
        raise rule_error(file, line, f"{name} must be a number. Got {cell[:40]!r}.") from None
    if not math.isfinite(value):
        raise rule_error(file, line, f"{name} must be finite. Got {cell[:40]!r}. Correct it.")
    return value
