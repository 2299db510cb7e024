"""Converts attributes of labels to and from other tools' files: their names beside our own, and their values."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Final

from tsr_engine.exchange.dataset import Dataset, Skipped, Track
from tsr_engine.exchange.frame_rows import TrackInfo
from tsr_engine.exchange.notes import notes_to_text
from tsr_engine.exchange.reading import rule_error
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.labels.model import AttributeValue
from tsr_engine.plural import plural

PREFIX: Final = "attribute:"
"""Prefix of a label's attribute whose name the format needs for something else."""
BOX_NAMES: Final = frozenset({"uid", "state", "source", "note", "score", "track_id", "keyframe"}) | frozenset(
    {"occluded", "outside", "rotation", "ignore"}
)
"""Attributes of boxes that this tool or CVAT writes, which are not a label's."""
_RESERVED_NAMES: Final = BOX_NAMES | {"frame_label"}
_SHARED_NAMES: Final = frozenset({"state", "source", "note"})
"""Names of ours that other tools use too: they are ours only beside a ``uid``."""


_OWN_MARK: Final = frozenset({"ignore"})
_ALL_MARKS: Final = _OWN_MARK | {"is_crowd", "ignored", "difficult"}
"""The other ones are Datumaro's, for the marks of COCO, MOT and Pascal VOC."""


def ignore_marks(attributes: JsonMapping) -> frozenset[str]:
    """Names of the attributes of a box that mark a region to ignore; in our own files the others are a label's."""
    return _OWN_MARK if attributes.get("uid") else _ALL_MARKS


def written_name(name: str) -> str:
    """The name under which an attribute of a label is written."""
    return f"{PREFIX}{name}" if name in _RESERVED_NAMES or name.startswith(PREFIX) else name


def track_attributes(info: TrackInfo) -> JsonObject:
    """The facts about a track as attributes of each of its boxes."""
    note = {"note": notes_to_text(info.notes)} if info.notes else {}
    label_attributes = {written_name(name): value for name, value in info.attributes.items()}
    return {"uid": info.uid, "state": info.state, "source": info.source, **note, **label_attributes}


def original_name(name: str) -> str:
    """Invert ``written_name``."""
    return name.removeprefix(PREFIX)


def track_facts(attributes: JsonMapping) -> tuple[str, str, str]:
    """State, source and note of a track, among the attributes of a box."""
    own = attributes if attributes.get("uid") else {}
    state, source, note = (str(own.get(name) or "") for name in ("state", "source", "note"))
    return state.strip() or "open", source.strip() or "imported", note


def label_values(attributes: JsonMapping, reserved: frozenset[str]) -> JsonObject:
    """The label's attributes among the attributes of a box, without empty texts.

    Args:
        attributes: all attributes by name.
        reserved: names that the format needs for something else.
    """
    if not attributes.keys() - reserved and not attributes.keys() & _SHARED_NAMES:
        return {}
    excluded = reserved if attributes.get("uid") else reserved - _SHARED_NAMES
    return {
        original_name(name): value
        for name, value in attributes.items()
        if name not in excluded and value not in ("", None)
    }


def value_as_text(value: AttributeValue) -> str:
    """The value as text for XML and CSV: ``true``, ``12.5``, or the text itself."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:.12g}" if isinstance(value, float | int) else value


def attributes_as_json(values: Mapping[str, AttributeValue]) -> str:
    """Attributes as one cell of a table: a JSON object, or an empty text if there are none."""
    return json.dumps(dict(values), ensure_ascii=False, separators=(",", ":")) if values else ""


def parse_attributes(value: object, file: str, where: int | str | None) -> dict[str, AttributeValue]:
    """Parse attributes from a JSON object or from a cell that holds one.

    Raises:
        ImportFormatError: it is not a JSON object, or a value is not true, false, a number or a text.
    """
    if value is None or value == "":
        return {}
    found = value
    if isinstance(value, str):
        try:
            found = json.loads(value)
        except (ValueError, RecursionError):
            found = None
    if not isinstance(found, dict):
        raise rule_error(file, where, f"attributes must be a JSON object. Got {str(value)[:40]!r}. Correct it.")
    out: dict[str, AttributeValue] = {}
    for name, each in found.items():
        if each is None or each == "":
            continue
        if not isinstance(each, bool | int | float | str) or (isinstance(each, float) and not math.isfinite(each)):
            rule = f"attribute {name[:40]!r} must be true, false, a number or a text. Got {str(each)[:40]!r}."
            raise rule_error(file, where, rule)
        out[name] = each
    return out


def lost_attributes(dataset: Dataset, *, all_of_them: bool, title: str) -> list[Skipped]:
    """Report the attributes of a data set that a format cannot store.

    Args:
        dataset: its tracks are read once.
        all_of_them: the format has no attributes; False: it has those of whole tracks.
        title: the format's title.
    """
    of_tracks = of_frames = 0
    for video in dataset.videos:
        for track in video.tracks():
            of_tracks += len(track.attributes)
            of_frames += len(track.changing)
    found = []
    if all_of_them and of_tracks:
        found.append(Skipped(f"{plural(of_tracks, 'attribute')} of tracks", f"{title} has no place for them."))
    if of_frames:
        what = f"{plural(of_frames, 'attribute')} that change from frame to frame"
        found.append(Skipped(what, f"{title} has no place for them."))
    return found


def json_members(values: Mapping[str, AttributeValue]) -> str:
    """Attributes as members of a JSON object with a trailing comma; empty if there are none."""
    return f"{json.dumps(dict(values), separators=(',', ':'))[1:-1]}," if values else ""


def frame_values(track: Track, k: int) -> dict[str, AttributeValue]:
    """The values of a track's changing attributes in its k-th frame."""
    return {name: values[k] for name, values in track.changing.items() if values[k] is not None}
