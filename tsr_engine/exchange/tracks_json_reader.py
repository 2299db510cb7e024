"""Reads plain JSON of tracks and detections."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tsr_engine.exchange.checks import Intake, refuse
from tsr_engine.exchange.dataset import NONE, REJECTED, UNSAID, Dataset
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.json_stream import heads, members
from tsr_engine.exchange.linking import LooseBoxes
from tsr_engine.exchange.manifest import MANIFEST
from tsr_engine.exchange.split import SUBSETS
from tsr_engine.exchange.tracks_csv_reader import own_files

__all__ = ["read_tracks_json", "sniff_tracks_json"]

_EDGES = ("box", "xyxy")
_SIZED = ("bbox", "xywh")
_IDS = ("id", "track_id", "uid", "track")
_CLASSES = ("class", "label", "class_name", "category", "class_id")
_SCORES = ("score", "confidence", "conf")
_VERSION = 1
_HEADS = frozenset({"format", "version", "video", "classes"})
_LISTS = {"tracks": "track", "detections": "detection", "negatives": "negative", "": "entry"}


def read_tracks_json(path: Path, target: ImportTarget) -> Dataset:
    """Read a file or folder.

    Raises:
        ImportFormatError: a broken rule.
    """
    intake = Intake(target)
    files = own_files(path, target.video, ".json")
    loose = LooseBoxes(intake, files[0].name)
    for file in files:
        _File(file, intake, loose).read()
    loose.settle()
    return intake.finish(files[0].name)


class _File:
    """One file."""

    def __init__(self, path: Path, intake: Intake, loose: LooseBoxes) -> None:
        self._path = path
        self._name = path.name
        self._intake = intake
        self._loose = loose
        self._origin = int(intake.target.switches.get("first_frame", "0"))
        self._scale = (1.0, 1.0)
        self._classes: list[str] | None = None
        self._seen: set[str] = set()

    def read(self) -> None:
        """Take all tracks and detections, one in memory at a time."""
        self._about(heads(self._path, _HEADS))
        known = False
        for key, place, value in members(self._path):
            if key not in _LISTS or (key == "" and place is None):
                continue
            known = True
            if place is None:
                raise refuse(self._name, key, "must be a list. Correct it.")
            if place:
                where = f"{_LISTS[key]} {place}"
                self._object(value, where)
                if key in ("tracks", "negatives") or (key == "" and "boxes" in value):
                    self._track(value, where, rejected=key == "negatives")
                else:
                    self._box(value, where, None)
        if not known:
            raise refuse(self._name, None, "must be an object with tracks or detections, or a list of either.")

    def _about(self, found: Mapping[str, Any]) -> None:
        version = found.get("version", _VERSION)
        if found.get("format") == "tsr-tracks" and version != _VERSION:
            raise refuse(self._name, None, f"version must be {_VERSION}. Got {str(version)[:20]}. Export it again.")
        video = found.get("video")
        if isinstance(video, dict) and "width" in video and "height" in video:
            width, height = (self._number(video[side], side, "video") for side in ("width", "height"))
            self._scale = self._intake.scale(width, height, self._name, "video")
        classes = found.get("classes")
        if classes is not None:
            if not isinstance(classes, list) or not all(isinstance(name, str) for name in classes):
                raise refuse(self._name, "classes", "must be a list of names. Correct it.")
            self._classes = classes

    def _object(self, entry: Any, where: str) -> None:
        if not isinstance(entry, dict):
            raise refuse(self._name, where, f"must be an object. Got {str(entry)[:40]!r}.")

    def _track(self, track: Mapping[str, Any], where: str, *, rejected: bool) -> None:
        uid = self._id(track, where)
        if not uid:
            raise refuse(self._name, where, "must have an id. Give the track a name.")
        if uid in self._seen:
            raise refuse(self._name, where, f"a second track is called {uid[:60]!r}. Give each its own id.")
        self._seen.add(uid)
        label = self._label(track, where, UNSAID)
        boxes = track.get("boxes", [])
        if not isinstance(boxes, list):
            raise refuse(self._name, where, "boxes must be a list. Correct it.")
        for number, box in enumerate(boxes, start=1):
            self._object(box, f"{where}, box {number}")
            self._box(box, f"{where}, box {number}", (uid, label))
        if boxes and uid in self._intake:
            self._intake.describe(
                uid,
                state=REJECTED if rejected else str(track.get("state", "open")),
                source=str(track.get("source", "imported")),
                notes=self._notes(track, where),
            )

    def _notes(self, track: Mapping[str, Any], where: str) -> list[tuple[int, str]]:
        notes = track.get("notes", [])
        good = isinstance(notes, list) and all(
            isinstance(note, list) and len(note) == 2 and type(note[0]) is int and isinstance(note[1], str)
            for note in notes
        )
        if not good:
            raise refuse(self._name, where, "notes must be a list of [frame, text]. Correct it.")
        return [(note[0] - self._origin, note[1]) for note in notes]

    def _box(self, box: Mapping[str, Any], where: str, track: tuple[str, int] | None) -> None:
        if "frame" not in box or type(box["frame"]) not in (int, float):
            raise refuse(self._name, where, f"must have a frame number. Got {str(box.get('frame'))[:40]!r}.")
        frame = self._intake.frame(box["frame"], self._name, where, origin=self._origin)
        score = next((box[name] for name in _SCORES if box.get(name) is not None), None)
        given: dict[str, Any] = {
            "file": self._name,
            "line": where,
            "key": self._flag(box, "key", where, True),
            "occluded": self._flag(box, "occluded", where, False),
            "ignore": self._flag(box, "ignore", where, False),
            "score": math.nan if score is None else self._number(score, "score", where),
        }
        edges = self._intake.edges(lambda: self._box_edges(box, where))
        label = self._label(box, where, UNSAID if track is None else track[1])
        uid = self._id(box, where) if track is None else track[0]
        if uid:
            self._intake.box(uid, frame, edges, label, **given)
        else:
            self._loose.add(frame, edges, label, **given)

    def _box_edges(self, box: Mapping[str, Any], where: str) -> tuple[float, float, float, float]:
        name = next((name for name in (*_EDGES, *_SIZED) if name in box), None)
        values = box[name] if name is not None else None
        if not isinstance(values, list) or len(values) != 4:
            raise refuse(
                self._name, where, f"must have box [x1, y1, x2, y2] or bbox [x, y, w, h]. Got {str(values)[:60]}."
            )
        a, b, c, d = (self._number(value, str(name), where) for value in values)
        if name in _SIZED:
            c, d = a + c, b + d
        sx, sy = self._scale
        return a * sx, b * sy, c * sx, d * sy

    def _id(self, entry: Mapping[str, Any], where: str) -> str:
        """Name of the track; empty: none."""
        value = next((entry[name] for name in _IDS if entry.get(name) is not None), None)
        if value is None or (type(value) is int and value < 0):
            return ""
        if type(value) not in (int, str):
            raise refuse(self._name, where, f"id must be a text or a whole number. Got {str(value)[:40]!r}.")
        return str(value)

    def _label(self, entry: Mapping[str, Any], where: str, default: int) -> int:
        value = next((entry[name] for name in _CLASSES if entry.get(name) is not None), None)
        if value is None:
            return default
        if type(value) is int:
            if value == NONE:
                return NONE
            if self._classes is None:
                return self._intake.label(str(value), self._name, where)
            if not 0 <= value < len(self._classes):
                raise refuse(self._name, where, f"class {value} must be 0 to {len(self._classes) - 1} of classes.")
            return self._intake.label(self._classes[value], self._name, where)
        if not isinstance(value, str):
            raise refuse(self._name, where, f"class must be a name or a number. Got {str(value)[:40]!r}.")
        return self._intake.label(value, self._name, where)

    def _flag(self, box: Mapping[str, Any], name: str, where: str, default: bool) -> bool:
        value = box.get(name, default)
        if value not in (True, False):
            raise refuse(self._name, where, f"{name} must be true or false. Got {str(value)[:40]!r}.")
        return bool(value)

    def _number(self, value: Any, name: str, where: str) -> float:
        if type(value) not in (int, float):
            raise refuse(self._name, where, f"{name} must be a number. Got {str(value)[:40]!r}.")
        try:
            return float(value)
        except OverflowError:
            raise refuse(self._name, where, f"{name} is too large. Correct it.") from None


def sniff_tracks_json(path: Path) -> bool:
    """Whether it is, or has, a JSON of tracks or detections of this kind."""
    files = [path]
    if path.is_dir():
        found = [*path.glob("*.json"), *(f for side in SUBSETS for f in path.glob(f"{side}/*.json"))]
        files = sorted(f for f in found if f.name != MANIFEST)[:1]
    for file in files:
        if file.suffix.lower() != ".json":
            return False
        with file.open("rb") as stream:
            start = stream.read(1 << 14)
        if b'"tsr-tracks"' in start:
            return True
        boxes = any(f'"{name}"'.encode() in start for name in (*_EDGES, *_SIZED))
        foreign = any(
            word in start for word in (b'"image_id"', b'"images"', b'"dm_format_version"', b'"videorectangle"')
        )
        return boxes and b'"frame"' in start and not foreign
    return False
