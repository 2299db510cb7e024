"""Reads the regions of a task: boxes at key frames, whose times must agree with their numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from itertools import pairwise

from tsr_engine.exchange.box_rules import Edges
from tsr_engine.exchange.dataset import UNSTATED_LABEL
from tsr_engine.exchange.ids import is_number, real_of
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.notes import notes_from_text
from tsr_engine.exchange.reading import rule_error
from tsr_engine.json_shapes import JsonMapping, JsonObject


def target_object(region: object) -> str:
    """Name of the object that a region is drawn on (``to_name``); empty: not stated."""
    name = region.get("to_name") if isinstance(region, dict) else None
    return name if isinstance(name, str) else ""


def is_rectangle(region: object) -> bool:
    """Whether a region is a video rectangle."""
    return isinstance(region, dict) and region.get("type") == "videorectangle"


def as_list(value: object) -> list[object]:
    """The value if it is a list, else an empty list."""
    return value if isinstance(value, list) else []


class TimeCheck:
    """Compares the times of key frames with their numbers, which Label Studio computes from them at its own rate."""

    def __init__(self, validator: ImportValidator, file: str, where: str) -> None:
        self._validator = validator
        self._file = file
        self._where = where
        self._rate = float(validator.target.video.rate or 0)
        self._checked = 0
        self._wrong_locations: list[str] = []
        self._first_mismatch = ""
        self._from_zero = 0

    def add(self, frame: int, time: object, location: str) -> None:
        """Compare the time of a key frame with its number from 1, or with its ordinal."""
        if not is_number(time):
            return
        time = real_of(time, "time", self._file, location)
        self._checked += 1
        self._from_zero += abs(time * self._rate - frame) < 0.25
        # A tolerance of half a frame, because times are rounded and some come from the player.
        if not frame - 0.5 <= time * self._rate <= frame + 1.5:
            self._wrong_locations.append(location)
            self._first_mismatch = self._first_mismatch or f"frame {frame + 1} is at {time:g} s"

    def report(self, fps: object) -> None:
        """Report times that disagree.

        Raises:
            ImportFormatError: most times belong to other frames.
        """
        video, rate = self._validator.target.video, f"{self._rate:g} frames/s"
        if len(self._wrong_locations) * 2 > self._checked:
            raise rule_error(
                self._file,
                self._wrong_locations[0],
                f"{self._first_mismatch}, but {video.name} has {rate}: it is another video, or Label Studio counted at "
                'another rate. Set framerate="$fps" in the labelling configuration.',
            )
        if self._from_zero * 2 > self._checked:
            reported = "key frames were taken by their number, from 1; their times begin at 0"
            self._validator.repair(f"{self._file}, {self._where}: {reported}.")
        for location in self._wrong_locations:
            self._validator.count(
                "Key frames were taken by their number; their time is that of another", self._file, location
            )
        if is_number(fps):
            self._validator.check_rate(real_of(fps, "fps", self._file, self._where), self._file, self._where)


def read_region(
    region: JsonObject,
    labels: list[object],
    attributes: JsonMapping,
    times: TimeCheck,
    validator: ImportValidator,
    file: str,
    where: str,
) -> None:
    """Pass the boxes of a region to the validator.

    Args:
        region: a video rectangle.
        labels: labels stated outside the region.
        attributes: answers to questions about it.
        times: collects its key frames.
        validator: takes the boxes.
        file: for messages.
        where: for messages.

    Raises:
        ImportFormatError: the region breaks a rule.
    """
    value = region.get("value")
    if not isinstance(value, dict) or not isinstance(value.get("sequence"), list):
        raise rule_error(file, where, "must have a value with a sequence. Export as JSON again.")
    _check_count(value, validator, file, where)
    names = as_list(value.get("labels")) or labels
    label = validator.label(str(names[0]), file, where) if names else UNSTATED_LABEL
    if len(names) != 1:
        kind = "Regions of several labels have the first one" if names else "Regions have no label"
        validator.count(kind, file, where)
    meta = _meta(region)
    uid = validator.unique_uid((meta.get("uid") or [str(region.get("id", ""))])[0].strip() or where, file, where)
    video = validator.target.video
    enabled_at: dict[int, bool] = {}
    placed: dict[int, JsonObject] = {}
    for index, key in enumerate(value["sequence"]):
        location = f"{where}, key frame {index + 1}"
        if not isinstance(key, dict):
            raise rule_error(file, location, "must be an object. Correct it.")
        frame = validator.frame(key.get("frame", ""), file, location, origin=1)
        times.add(frame, key.get("time"), location)
        edges = validator.boxes.edges(partial(_edges, key, validator, file, location))
        if validator.box(uid, frame, edges, label, file=file, line=location):
            enabled_at[frame] = key.get("enabled", True) is not False
            placed[frame] = key
    for (start, first), (end, second) in pairwise(sorted(placed.items())):
        for frame, key in _turning_keys(start, first, end, second) if enabled_at[start] else ():
            edges = _edges(key, validator, file, where, is_drawn=False)
            validator.box(uid, frame, edges, label, file=file, line=where, key=False)
    for frame, enabled in enabled_at.items():
        if not enabled and frame + 1 not in enabled_at:
            validator.hide_from(uid, frame + 1)
    if enabled_at and not any(isinstance(key, dict) and "enabled" in key for key in value["sequence"]):
        validator.count(
            "Regions without enabled do not state their end; they were shown up to the last frame", file, where
        )
    validator.describe(
        uid,
        state=(meta.get("state") or ["open"])[0],
        source=(meta.get("source") or ["imported"])[0],
        notes=notes_from_text("\n".join(meta.get("note", [])), min(enabled_at, default=0)),
        attributes=attributes,
        # A region that is enabled at its last key frame lasts to the end of the video.
        until=video.frames - 1 if enabled_at and enabled_at[max(enabled_at)] else -1,
    )


def _edges(key: JsonObject, validator: ImportValidator, file: str, where: str, is_drawn: bool = True) -> Edges:
    """The upright box of a key frame; one that stands in the file (``is_drawn``) is reported if it is rotated."""
    video = validator.target.video
    x, y, width, height = (
        _number(key.get(name), name, file, where) / 100 * side
        for name, side in (("x", video.width), ("y", video.height), ("width", video.width), ("height", video.height))
    )
    rotation = _number(key["rotation"], "rotation", file, where) if key.get("rotation") else 0.0
    if rotation % 360 and math.isfinite(rotation):
        x, y, width, height = _upright(x, y, width, height, rotation)
        if is_drawn:
            validator.count("Rotated boxes were replaced by the upright boxes around them", file, where)
    return x, y, x + width, y + height


def _turning_keys(start: int, first: JsonObject, end: int, second: JsonObject) -> Iterator[tuple[int, JsonObject]]:
    """The frames between two key frames of different rotation, where the upright boxes lie on no straight lines.

    Label Studio moves the box evenly and turns it the shorter way (``interpolateProp`` in its ``utils/props.ts``).
    """
    rotation, last_rotation = first.get("rotation") or 0.0, second.get("rotation") or 0.0
    turn = (last_rotation - rotation + 180) % 360 - 180
    for frame in range(start + 1, end) if turn else ():
        share = (frame - start) / (end - start)
        key = {name: first[name] + (second[name] - first[name]) * share for name in ("x", "y", "width", "height")}
        yield frame, key | {"rotation": rotation + turn * share}


def _check_count(value: JsonObject, validator: ImportValidator, file: str, where: str) -> None:
    video, duration = validator.target.video, value.get("duration")
    if not is_number(value.get("framesCount")):
        return
    count = real_of(value["framesCount"], "framesCount", file, where)
    # Label Studio rounds the duration, so the count may be off by one.
    if abs(count - video.frames) > 1:
        rate = float(video.rate or 0)
        is_at_rate = is_number(duration) and abs(count - real_of(duration, "duration", file, where) * rate) <= 1
        # The duration is the file's: a sound track is often a little longer than the pictures.
        if is_at_rate and 0 < count - video.frames <= rate:
            validator.count("Regions count the frames of a sound track that is longer than the pictures", file, where)
            return
        raise rule_error(
            file,
            where,
            f"was drawn on {count:g} frames, {video.name} has {video.frames}: it is another video, or Label Studio "
            'counted at another rate. Set framerate="$fps" in the labelling configuration.',
        )


def _meta(region: JsonObject) -> dict[str, list[str]]:
    """Lines ``name=value`` of ``meta.text`` by name; other lines are notes."""
    meta = region.get("meta")
    lines = meta.get("text") if isinstance(meta, dict) else None
    out: dict[str, list[str]] = {}
    for line in [lines] if isinstance(lines, str) else as_list(lines):
        name, equals, value = str(line).partition("=")
        known = bool(equals) and name in ("uid", "state", "source", "note")
        out.setdefault(name if known else "note", []).append(value if known else str(line))
    return out


def _number(value: object, name: str, file: str, where: str) -> float:
    if not is_number(value):
        raise rule_error(file, where, f"{name} must be a number. Got {str(value)[:40]!r}.")
    return real_of(value, name, file, where)


def _upright(x: float, y: float, width: float, height: float, rotation: float) -> Edges:
    """The upright box around a box that is rotated about its upper left corner, clockwise in degrees."""
    cos, sin = math.cos(math.radians(rotation)), math.sin(math.radians(rotation))
    corners = [(0.0, 0.0), (width, 0.0), (0.0, height), (width, height)]
    xs = [x + a * cos - b * sin for a, b in corners]
    ys = [y + a * sin + b * cos for a, b in corners]
    return min(xs), min(ys), max(xs) - min(xs), max(ys) - min(ys)
