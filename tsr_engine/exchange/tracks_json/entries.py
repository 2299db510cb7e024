"""Yields the entries of a JSON file of tracks or detections, whichever lists they are in.

It reads ``tracks``, ``detections``, ``negatives`` and ``frames`` of an object, a list of entries, an object whose keys
are frames (``{"10": [...]}``), and a list with one list per frame, or with the text of one, as Ultralytics'
``results.to_json()`` writes it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tsr_engine.exchange.json_stream import members
from tsr_engine.exchange.reading import rule_error
from tsr_engine.exchange.table_columns import MISSING_VALUES
from tsr_engine.json_shapes import JsonMapping

FRAME_KEY = re.compile(r"(?:frame[_ ]?)?(\d{1,9})", re.ASCII | re.IGNORECASE)
"""Pattern of a key that is a frame."""
_LISTS = {"tracks": "track", "detections": "detection", "negatives": "negative", "frames": "frame", "": "entry"}
_BOX_LISTS = ("detections", "objects", "predictions", "boxes", "annotations")
"""Keys of an entry about a frame that hold its boxes."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry.

    Attributes:
        kind: key of its list; empty: the file is a list, or its keys are frames.
        where: its place in words.
        value: as in the file.
        frame: frame stated outside the entry; None: none.
        ordered: whether ``frame`` is the list's index from 0, not a number in the file.
    """

    kind: str
    where: str
    value: object
    frame: int | None = None
    ordered: bool = False


def entries(path: Path, file: str) -> Iterator[Entry | None]:
    """Yield the entries of a file, one in memory at a time; None where a list, which may be empty, begins.

    Args:
        path: the file.
        file: its name for messages.

    Raises:
        ImportFormatError: as ``members``, or a known key has no list.
    """
    for key, position, value in members(path, name=file):
        frame = FRAME_KEY.fullmatch(key)
        if frame:
            name = f"frame {key}"
            if position is None:
                yield Entry("", name, value, int(frame[1]))
            elif position:
                yield Entry("", f"{name}, box {position}", value, int(frame[1]))
        elif key in _LISTS and position is not None:
            if not position:
                yield None
                continue
            inner = _parse_list(value) if key == "" else None
            if inner is None:
                yield Entry(key, f"{_LISTS[key]} {position}", value)
                continue
            for box_position, each in enumerate(inner, start=1):
                yield Entry("", f"list {position}, box {box_position}", each, position - 1, ordered=True)
        elif key in _LISTS and key:
            raise rule_error(file, key, "must be a list. Correct it.")


def first_value(entry: JsonMapping, names: Sequence[str]) -> Any:  # Any: a value of JSON
    """The first informative value among some keys; None: there is none."""
    for name in names:
        value = entry.get(name)
        if value is not None and not (isinstance(value, str) and value.strip().lower() in MISSING_VALUES):
            return value
    return None


def inner_boxes(value: object) -> list[object] | None:
    """The boxes within an entry about a frame or track; None: it has no list of boxes."""
    if not isinstance(value, dict):
        return None
    return next((value[name] for name in _BOX_LISTS if isinstance(value.get(name), list)), None)


def _parse_list(value: object) -> list[object] | None:
    if isinstance(value, str):
        try:
            value = json.loads(value)
        except (ValueError, RecursionError):
            return None
    return value if isinstance(value, list) else None
