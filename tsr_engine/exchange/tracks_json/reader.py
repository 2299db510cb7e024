"""Reads plain JSON of tracks and detections."""

from __future__ import annotations

import math
import re
from contextlib import suppress
from pathlib import Path

from tsr_engine.exchange.attributes import attributes_in
from tsr_engine.exchange.checks import ImportValidator
from tsr_engine.exchange.dataset import REJECTED, UNSAID, Dataset
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.frame_origin import FrameOrigin
from tsr_engine.exchange.ids import is_number
from tsr_engine.exchange.json_stream import heads
from tsr_engine.exchange.linking import LooseBoxes
from tsr_engine.exchange.manifest import MANIFEST
from tsr_engine.exchange.reading import refuse
from tsr_engine.exchange.split import SUBSETS
from tsr_engine.exchange.subject import Part, choose
from tsr_engine.exchange.table_columns import CLASSES, NAMES, class_in, edges_of, is_id_column, normal
from tsr_engine.exchange.tracks_csv.cells import whole_box
from tsr_engine.exchange.tracks_csv.reader import OWN_NUMBERS, own_files
from tsr_engine.exchange.tracks_json.rows import FRAME_KEY, Entry, entries, first_of, inner_of
from tsr_engine.io.plain_numbers import real_number, whole_number
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.plural import plural
from tsr_engine.track_table import NO_CLASS

__all__ = ["read_tracks_json", "sniff_tracks_json"]

_BOXES = (("box", False), ("xyxy", False), ("bbox", True), ("xywh", True))
"""Keys of a box, and whether its four numbers are a corner with a size."""
_IDS = (*NAMES["track"], "uid")
_VERSION = 1
_HEADS = frozenset({"format", "version", "video", "classes", "width", "height"})


def read_tracks_json(path: Path, target: ImportTarget) -> Dataset:
    """Read a file or folder.

    Raises:
        ImportFormatError: an entry breaks a rule.
    """
    validator = ImportValidator(target)
    files = own_files(path, target.video, ".json")
    loose = LooseBoxes(validator, files[0].name)
    for file in files:
        _File(file, validator, loose).read()
    loose.finish()
    return validator.finish(files[0].name)


class _File:
    """Reads one file."""

    def __init__(self, path: Path, validator: ImportValidator, loose: LooseBoxes) -> None:
        self._path = path
        self._name = path.name
        self._validator = validator
        self._loose = loose
        self._origin = FrameOrigin(validator)
        self._scale = (1.0, 1.0)
        self._classes: list[str] | None = None
        self._own = False
        self._ordered = False
        self._video: str | None = None
        self._seen: set[str] = set()

    def read(self) -> None:
        """Take all tracks and detections, one in memory at a time."""
        self._about(heads(self._path, _HEADS))
        if not self._own:
            self._settle()
        known = False
        for entry in entries(self._path):
            known = True
            if entry is not None and self._video in (None, _video_of(entry.value)):
                self._entry(entry)
        if not known:
            raise refuse(self._name, None, "must be an object with tracks or detections, or a list of either.")
        if self._ordered:
            reported = "lists without frame numbers were taken as those of frames 0, 1, 2 ... in their order"
            self._validator.repair(f"{self._name}: {reported}.")

    def _settle(self) -> None:
        """Find the video that the entries name, if any, and its first frame number."""
        documented = False
        videos = dict.fromkeys(_video_of(entry.value) for entry in entries(self._path) if entry is not None)
        if videos.keys() - {""}:
            parts = [Part(name, (name,), ids=(name,)) for name in videos]
            self._video = choose(parts, self._validator, self._name, "video")[0].content
        if self._origin.decided:
            return
        for entry in entries(self._path):
            if entry is not None and self._video in (None, _video_of(entry.value)):
                documented |= entry.kind in ("tracks", "detections", "negatives")
                self._look(entry.value, None if entry.ordered else entry.frame)
        self._origin.decide(self._name, documented=documented)

    def _look(self, value: object, around: int | None) -> None:
        """Collect the frame numbers of an entry and of its boxes."""
        number = _frame_of(value)
        number = around if number is None else number
        # Values other than numbers are refused when they are read.
        with suppress(ValueError, OverflowError):
            if isinstance(number, str):
                self._origin.add(real_number(number))
            elif isinstance(number, (int, float)):
                self._origin.add(float(number))
        for each in inner_of(value) or ():
            self._look(each, None)

    def _entry(self, entry: Entry) -> None:
        where = entry.where
        value = self._object(entry.value, where)
        number, inner = _frame_of(value), inner_of(value)
        if number is None and entry.frame is not None:
            self._ordered |= entry.ordered
            number = entry.frame + (self._origin.origin if entry.ordered else 0)
        if entry.kind in ("tracks", "negatives") or (entry.kind == "" and "boxes" in value and number is None):
            self._track(value, where, rejected=entry.kind == "negatives")
        elif inner is not None and number is not None:
            for place, each in enumerate(inner, start=1):
                spot = f"{where}, box {place}"
                self._box({"frame": number, **self._object(each, spot)}, spot, None)
        else:
            self._box({**value, "frame": number}, where, None)

    def _about(self, found: JsonMapping) -> None:
        version = found.get("version", _VERSION)
        self._own = found.get("format") == "tsr-tracks"
        if self._own:
            self._origin = FrameOrigin(self._validator, 0, sure=True)
        if self._own and version != _VERSION:
            raise refuse(self._name, None, f"version must be {_VERSION}. Got {str(version)[:20]}. Export it again.")
        video = found.get("video")
        if isinstance(video, str):
            video = {"name": video}
        if is_number(found.get("width")) and is_number(found.get("height")):
            video = {"width": found["width"], "height": found["height"], **(video if isinstance(video, dict) else {})}
        if isinstance(video, dict) and isinstance(video.get("name"), str):
            digest, ours = video.get("sha256"), self._validator.target.video.sha256
            part = Part(None, (video["name"],), known=digest == ours if digest and ours else None)
            choose([part], self._validator, self._name, "video")
        if isinstance(video, dict) and "width" in video and "height" in video:
            width, height = (self._number(video[side], side, "video") for side in ("width", "height"))
            self._scale = self._validator.scale(width, height, self._name, "video")
        frames = video.get("frames") if isinstance(video, dict) else None
        if isinstance(frames, int) and frames != self._validator.target.video.frames:
            target = self._validator.target.video
            reported = f"is about a video of {plural(frames, 'frame')}, {target.name} has {target.frames}"
            self._validator.repair(f"{self._name}: {reported}.")
        classes = found.get("classes")
        if classes is not None:
            if not isinstance(classes, list) or not all(isinstance(name, str) for name in classes):
                raise refuse(self._name, "classes", "must be a list of names. Correct it.")
            self._classes = classes

    def _object(self, entry: object, where: str) -> JsonObject:
        if not isinstance(entry, dict):
            raise refuse(self._name, where, f"must be an object. Got {str(entry)[:40]!r}.")
        return entry

    def _track(self, track: JsonMapping, where: str, *, rejected: bool) -> None:
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
            spot = f"{where}, box {number}"
            self._box(self._object(box, spot), spot, (uid, label))
        if boxes and uid in self._validator:
            self._validator.describe(
                uid,
                state=REJECTED if rejected else str(track.get("state", "open")),
                source=str(track.get("source", "imported")),
                notes=self._notes(track, where),
                said=attributes_in(track.get("attributes"), self._name, where),
            )

    def _notes(self, track: JsonMapping, where: str) -> list[tuple[int, str]]:
        notes = track.get("notes", [])
        good = isinstance(notes, list) and all(
            isinstance(note, list) and len(note) == 2 and type(note[0]) is int and isinstance(note[1], str)
            for note in notes
        )
        if not good:
            raise refuse(self._name, where, "notes must be a list of [frame, text]. Correct it.")
        return [(note[0] - self._origin.origin, note[1]) for note in notes]

    def _box(self, box: JsonMapping, where: str, track: tuple[str, int] | None) -> None:
        if not self._own:
            box = {normal(name): value for name, value in box.items()}
        number = first_of(box, NAMES["frame"])
        others = [name for name in NAMES["frame"] if is_number(box.get(name)) and box[name] != number]
        if is_number(number) and others:
            raise refuse(self._name, where, f"says frame {number} and {others[0]} {box[others[0]]}. Keep one of them.")
        if type(number) not in (int, float, str):
            raise refuse(
                self._name,
                where,
                f"must have a frame number. Got {str(number)[:40]!r}. Of results for each picture, keep a list each.",
            )
        frame = self._origin.frame(number, self._name, where)
        score = first_of(box, NAMES["score"])
        given: JsonObject = {
            "file": self._name,
            "line": where,
            "key": self._flag(box, "key", where, True),
            "occluded": self._flag(box, "occluded", where, False),
            "ignore": self._flag(box, "ignore", where, False),
            "score": math.nan if score is None else self._number(score, "score", where),
            "said": attributes_in(box.get("attributes"), self._name, where),
        }
        edges = self._validator.boxes.edges(lambda: self._box_edges(box, where))
        label = self._label(box, where, UNSAID if track is None else track[1])
        uid = self._id(box, where) if track is None else track[0]
        if uid:
            self._validator.box(uid, frame, edges, label, **given)
        else:
            self._loose.add(frame, edges, label, **given)

    def _box_edges(self, box: JsonMapping, where: str) -> tuple[float, float, float, float]:
        name, sized = next(((name, sized) for name, sized in _BOXES if name in box), ("", False))
        value = box[name] if name else box
        edges = edges_of(value, sized=sized)
        if edges is None:
            got = str(box.get(name))[:60]
            raise refuse(self._name, where, f"must have box [x1, y1, x2, y2] or bbox [x, y, w, h]. Got {got}.")
        a, b, c, d = edges if self._own else whole_box(edges, self._name, where)
        sx, sy = self._scale
        return a * sx, b * sy, c * sx, d * sy

    def _id(self, entry: JsonMapping, where: str) -> str:
        """Name of the track; empty: none."""
        given = (entry[name] for name in _IDS if entry.get(name) is not None)
        value = next(given, None) if self._own else first_of(entry, _IDS)
        if isinstance(value, float) and value == value // 1:
            value = int(value)
        if value is None or (type(value) is int and value < 0):
            return ""
        if type(value) not in (int, str):
            raise refuse(self._name, where, f"id must be a text or a whole number. Got {str(value)[:40]!r}.")
        return "" if value == "-1" else str(value)

    def _label(self, entry: JsonMapping, where: str, default: int) -> int:
        given = {name: entry[name] for name in CLASSES if entry.get(name) is not None}
        wrong = next((value for value in given.values() if type(value) not in (int, str, float)), None)
        if wrong is not None:
            raise refuse(self._name, where, f"class must be a name or a number. Got {str(wrong)[:40]!r}.")
        cells = {name: f"{value:g}" if isinstance(value, float) else str(value) for name, value in given.items()}
        cell = class_in(cells.values())
        if not cell:
            return default
        try:
            number = whole_number(cell)
        except ValueError:
            return self._validator.label(cell, self._name, where)
        if number == NO_CLASS:
            return NO_CLASS
        holding = [name for name, value in cells.items() if value == cell]
        named = not any(is_id_column(name) or not isinstance(given[name], str) for name in holding)
        if self._classes is not None:
            if named and cell in self._classes:
                return self._validator.label(cell, self._name, where)
            if not 0 <= number < len(self._classes):
                raise refuse(self._name, where, f"class {number} must be 0 to {len(self._classes) - 1} of classes.")
            return self._validator.label(self._classes[number], self._name, where)
        if named:
            return self._validator.label(cell, self._name, where)
        if not self._own and cell not in self._validator.target.label_map:
            self._validator.count(OWN_NUMBERS, self._name, where)
        return self._validator.label(cell, self._name, where, number=True)

    def _flag(self, box: JsonMapping, name: str, where: str, default: bool) -> bool:
        value = box.get(name, default)
        if value not in (True, False):
            raise refuse(self._name, where, f"{name} must be true or false. Got {str(value)[:40]!r}.")
        return bool(value)

    def _number(self, value: object, name: str, where: str) -> float:
        try:
            if isinstance(value, str):
                return real_number(value)
            if is_number(value):
                return float(value)
        except ValueError:
            pass
        except OverflowError:
            raise refuse(self._name, where, f"{name} is too large. Correct it.") from None
        raise refuse(self._name, where, f"{name} must be a number. Got {str(value)[:40]!r}.")


def _video_of(value: object) -> str:
    """What an entry says of its video; empty: nothing."""
    found = first_of(value, NAMES["video"]) if isinstance(value, dict) else None
    return str(found).strip() if isinstance(found, (str, int)) else ""


def _frame_of(value: object) -> object:
    """What an entry says of its frame; None: nothing."""
    if not isinstance(value, dict):
        return None
    found = first_of(value, NAMES["frame"])
    return first_of({normal(name): each for name, each in value.items()}, NAMES["frame"]) if found is None else found


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
        # Lists of Ultralytics' texts have their quotes escaped.
        start = start.lower().replace(b'\\"', b'"')
        names = {part.decode("latin-1") for part in re.findall(rb'"([a-z_0-9 .-]{1,40})"\s*:', start)}
        boxes = names & {"box", "xyxy", "bbox", "xywh", *NAMES["x1"]}
        foreign = names & {"image_id", "images", "dm_format_version", "framescount"} or b'"videorectangle"' in start
        frames = names & {*NAMES["frame"], "confidence"} or any(map(FRAME_KEY.fullmatch, names))
        return bool(boxes and frames and not foreign)
    return False
