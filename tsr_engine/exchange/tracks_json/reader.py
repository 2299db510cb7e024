"""Reads plain JSON of tracks and detections."""

from __future__ import annotations

import math
import re
from contextlib import suppress
from pathlib import Path

from tsr_engine.exchange.attributes import parse_attributes
from tsr_engine.exchange.box_rules import Edges, check_pixels, scaled
from tsr_engine.exchange.dataset import REJECTED, UNSTATED_LABEL, Dataset
from tsr_engine.exchange.file_listing import head_of
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.frame_origin import FrameOrigin
from tsr_engine.exchange.ids import is_number
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.json_stream import read_members
from tsr_engine.exchange.linking import UntrackedBoxes
from tsr_engine.exchange.manifest import MANIFEST
from tsr_engine.exchange.reading import rule_error
from tsr_engine.exchange.split import SUBSETS
from tsr_engine.exchange.table_columns import (
    CLASS_COLUMNS,
    COLUMN_NAMES,
    class_of_cells,
    edges_of,
    is_id_column,
    normalized,
)
from tsr_engine.exchange.tracks_csv.reader import CLASS_NUMBERS_REPORT, files_of_video, name_in
from tsr_engine.exchange.tracks_json.entries import FRAME_KEY, Entry, entries, first_value, inner_boxes
from tsr_engine.exchange.video_matching import VideoPart, choose_parts
from tsr_engine.io.plain_numbers import parse_real, parse_whole
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.plural import plural
from tsr_engine.track_table import NO_CLASS

_BOX_KEYS = (("box", False), ("xyxy", False), ("bbox", True), ("xywh", True))
"""Keys of a box, and whether its four numbers are a corner with a size."""
_ID_KEYS = (*COLUMN_NAMES["track"], "uid")
_VERSION = 1
_HEAD_KEYS = frozenset({"format", "version", "video", "classes", "width", "height"})


def read_tracks_json(path: Path, target: ImportTarget) -> Dataset:
    """Read a file or folder.

    Raises:
        ImportFormatError: an entry breaks a rule.
    """
    validator = ImportValidator(target)
    files = files_of_video(path, target.video, ".json")
    loose = UntrackedBoxes(validator, files[0].name)
    for file in files:
        _File(file, name_in(path, file), validator, loose).read()
    loose.finish()
    return validator.finish(files[0].name)


class _File:
    """Reads one file."""

    def __init__(self, path: Path, name: str, validator: ImportValidator, loose: UntrackedBoxes) -> None:
        self._path = path
        self._name = name
        self._validator = validator
        self._loose = loose
        self._origin = FrameOrigin(validator)
        self._scale = (1.0, 1.0)
        self._classes: list[str] | None = None
        self._is_own_format = False
        self._frames_by_order = False
        self._video: str | None = None
        self._uids: set[str] = set()

    def read(self) -> None:
        """Take all tracks and detections, one in memory at a time."""
        self._read_head(read_members(self._path, _HEAD_KEYS, name=self._name))
        if not self._is_own_format:
            self._find_video_and_origin()
        has_entries = False
        for entry in entries(self._path, self._name):
            has_entries = True
            if entry is not None and self._video in (None, _video_of(entry.value)):
                self._entry(entry)
        if not has_entries:
            raise rule_error(self._name, None, "must be an object with tracks or detections, or a list of either.")
        if self._frames_by_order:
            report = "lists without frame numbers were taken as those of frames 0, 1, 2 ... in their order"
            self._validator.repair(f"{self._name}: {report}.")

    def _find_video_and_origin(self) -> None:
        """Find the video that the entries name, if any, and its first frame number."""
        documented = False
        videos = dict.fromkeys(_video_of(entry.value) for entry in entries(self._path, self._name) if entry is not None)
        if videos.keys() - {""}:
            parts = [VideoPart(name, (name,), ids=(name,)) for name in videos]
            self._video = choose_parts(parts, self._validator, self._name, "video")[0].content
        if self._origin.decided:
            return
        for entry in entries(self._path, self._name):
            if entry is not None and self._video in (None, _video_of(entry.value)):
                documented |= entry.kind in ("tracks", "detections", "negatives")
                self._collect_frames(entry.value, None if entry.ordered else entry.frame)
        self._origin.decide(self._name, documented=documented)

    def _collect_frames(self, value: object, outer_frame: int | None) -> None:
        """Collect the frame numbers of an entry and of its boxes."""
        number = _frame_of(value)
        number = outer_frame if number is None else number
        # Values other than numbers are refused when they are read.
        with suppress(ValueError, OverflowError):
            if isinstance(number, str):
                self._origin.add(parse_real(number))
            elif isinstance(number, (int, float)):
                self._origin.add(float(number))
        for each in inner_boxes(value) or ():
            self._collect_frames(each, None)

    def _entry(self, entry: Entry) -> None:
        where = entry.where
        value = self._object(entry.value, where)
        number, inner = _frame_of(value), inner_boxes(value)
        if number is None and entry.frame is not None:
            self._frames_by_order |= entry.ordered
            number = entry.frame + (self._origin.origin if entry.ordered else 0)
        if entry.kind in ("tracks", "negatives") or (entry.kind == "" and "boxes" in value and number is None):
            self._track(value, where, rejected=entry.kind == "negatives")
        elif inner is not None and number is not None:
            for position, each in enumerate(inner, start=1):
                location = f"{where}, box {position}"
                self._box({"frame": number, **self._object(each, location)}, location, None)
        else:
            self._box({**value, "frame": number}, where, None)

    def _read_head(self, head: JsonMapping) -> None:
        version = head.get("version", _VERSION)
        self._is_own_format = head.get("format") == "tsr-tracks"
        if self._is_own_format:
            self._origin = FrameOrigin(self._validator, 0, is_certain=True)
        if self._is_own_format and version != _VERSION:
            raise rule_error(self._name, None, f"version must be {_VERSION}. Got {str(version)[:20]}. Export it again.")
        video = head.get("video")
        video = {"name": video} if isinstance(video, str) else video if isinstance(video, dict) else {}
        if is_number(head.get("width")) and is_number(head.get("height")):
            video = {"width": head["width"], "height": head["height"], **video}
        if isinstance(video.get("name"), str):
            digest, video_digest = video.get("sha256"), self._validator.target.video.sha256
            part = VideoPart(
                None, (video["name"],), is_match=digest == video_digest if digest and video_digest else None
            )
            choose_parts([part], self._validator, self._name, "video")
        if "width" in video and "height" in video:
            width, height = (self._number(video[side], side, "video") for side in ("width", "height"))
            self._scale = self._validator.scale(width, height, self._name, "video")
        frames = video.get("frames")
        if isinstance(frames, int) and frames != self._validator.target.video.frames:
            target = self._validator.target.video
            report = f"is about a video of {plural(frames, 'frame')}, {target.name} has {target.frames}"
            self._validator.repair(f"{self._name}: {report}.")
        classes = head.get("classes")
        if classes is not None:
            if not isinstance(classes, list) or not all(isinstance(name, str) for name in classes):
                raise rule_error(self._name, "classes", "must be a list of names. Correct it.")
            self._classes = classes

    def _object(self, entry: object, where: str) -> JsonObject:
        if not isinstance(entry, dict):
            raise rule_error(self._name, where, f"must be an object. Got {str(entry)[:40]!r}.")
        return entry

    def _track(self, track: JsonMapping, where: str, *, rejected: bool) -> None:
        uid = self._id(track, where)
        if not uid:
            raise rule_error(self._name, where, "must have an id. Give the track a name.")
        if uid in self._uids:
            raise rule_error(self._name, where, f"a second track is called {uid[:60]!r}. Give each its own id.")
        self._uids.add(uid)
        label = self._label(track, where, UNSTATED_LABEL)
        boxes = track.get("boxes", [])
        if not isinstance(boxes, list):
            raise rule_error(self._name, where, "boxes must be a list. Correct it.")
        for number, box in enumerate(boxes, start=1):
            location = f"{where}, box {number}"
            self._box(self._object(box, location), location, (uid, label))
        if boxes and uid in self._validator:
            self._validator.describe(
                uid,
                state=REJECTED if rejected else str(track.get("state", "open")),
                source=str(track.get("source", "imported")),
                notes=self._notes(track, where),
                attributes=parse_attributes(track.get("attributes"), self._name, where),
            )

    def _notes(self, track: JsonMapping, where: str) -> list[tuple[int, str]]:
        notes = track.get("notes", [])
        is_valid = isinstance(notes, list) and all(
            isinstance(note, list) and len(note) == 2 and type(note[0]) is int and isinstance(note[1], str)
            for note in notes
        )
        if not is_valid:
            raise rule_error(self._name, where, "notes must be a list of [frame, text]. Correct it.")
        return [(note[0] - self._origin.origin, note[1]) for note in notes]

    def _box(self, box: JsonMapping, where: str, track: tuple[str, int] | None) -> None:
        if not self._is_own_format:
            box = {normalized(name): value for name, value in box.items()}
        number = first_value(box, COLUMN_NAMES["frame"])
        others = [name for name in COLUMN_NAMES["frame"] if is_number(box.get(name)) and box[name] != number]
        if is_number(number) and others:
            other = f"{others[0]} {box[others[0]]}"
            raise rule_error(self._name, where, f"says frame {number} and {other}. Keep one of them.")
        if type(number) not in (int, float, str):
            raise rule_error(
                self._name,
                where,
                f"must have a frame number. Got {str(number)[:40]!r}. Of results for each picture, keep a list each.",
            )
        frame = self._origin.frame(number, self._name, where)
        score = first_value(box, COLUMN_NAMES["score"])
        box_fields: JsonObject = {
            "file": self._name,
            "line": where,
            "key": self._flag(box, "key", where, True),
            "occluded": self._flag(box, "occluded", where, False),
            "ignore": self._flag(box, "ignore", where, False),
            "score": math.nan if score is None else self._number(score, "score", where),
            "attributes": parse_attributes(box.get("attributes"), self._name, where),
        }
        edges = self._validator.boxes.edges(lambda: self._box_edges(box, where))
        label = self._label(box, where, UNSTATED_LABEL if track is None else track[1])
        uid = self._id(box, where) if track is None else track[0]
        if uid:
            self._validator.box(uid, frame, edges, label, **box_fields)
        else:
            self._loose.add(frame, edges, label, **box_fields)

    def _box_edges(self, box: JsonMapping, where: str) -> Edges:
        name, sized = next(((name, sized) for name, sized in _BOX_KEYS if name in box), ("", False))
        value = box[name] if name else box
        edges = edges_of(value, sized=sized)
        if edges is None:
            got = str(box.get(name))[:60]
            raise rule_error(self._name, where, f"must have box [x1, y1, x2, y2] or bbox [x, y, w, h]. Got {got}.")
        return scaled(edges if self._is_own_format else check_pixels(edges, self._name, where), self._scale)

    def _id(self, entry: JsonMapping, where: str) -> str:
        """Name of the track; empty: none."""
        ids = (entry[name] for name in _ID_KEYS if entry.get(name) is not None)
        value = next(ids, None) if self._is_own_format else first_value(entry, _ID_KEYS)
        if isinstance(value, float) and value == value // 1:
            value = int(value)
        if value is None or (type(value) is int and value < 0):
            return ""
        if type(value) not in (int, str):
            raise rule_error(self._name, where, f"id must be a text or a whole number. Got {str(value)[:40]!r}.")
        return "" if value == "-1" else str(value)

    def _label(self, entry: JsonMapping, where: str, default: int) -> int:
        values = {name: entry[name] for name in CLASS_COLUMNS if entry.get(name) is not None}
        wrong = next((value for value in values.values() if type(value) not in (int, str, float)), None)
        if wrong is not None:
            raise rule_error(self._name, where, f"class must be a name or a number. Got {str(wrong)[:40]!r}.")
        cells = {name: f"{value:g}" if isinstance(value, float) else str(value) for name, value in values.items()}
        cell = class_of_cells(cells.values())
        if not cell:
            return default
        try:
            number = parse_whole(cell)
        except ValueError:
            return self._validator.label(cell, self._name, where)
        if number == NO_CLASS:
            return NO_CLASS
        columns = [name for name, value in cells.items() if value == cell]
        is_name = not any(is_id_column(name) or not isinstance(values[name], str) for name in columns)
        if self._classes is not None:
            if is_name and cell in self._classes:
                return self._validator.label(cell, self._name, where)
            if not 0 <= number < len(self._classes):
                raise rule_error(self._name, where, f"class {number} must be 0 to {len(self._classes) - 1} of classes.")
            return self._validator.label(self._classes[number], self._name, where)
        if is_name:
            return self._validator.label(cell, self._name, where)
        if not self._is_own_format and cell not in self._validator.target.label_map:
            self._validator.count(CLASS_NUMBERS_REPORT, self._name, where)
        return self._validator.label(cell, self._name, where, number=True)

    def _flag(self, box: JsonMapping, name: str, where: str, default: bool) -> bool:
        value = box.get(name, default)
        if value not in (True, False):
            raise rule_error(self._name, where, f"{name} must be true or false. Got {str(value)[:40]!r}.")
        return bool(value)

    def _number(self, value: object, name: str, where: str) -> float:
        try:
            if isinstance(value, str):
                return parse_real(value)
            if is_number(value):
                return float(value)
        except ValueError:
            pass
        except OverflowError:
            raise rule_error(self._name, where, f"{name} is too large. Correct it.") from None
        raise rule_error(self._name, where, f"{name} must be a number. Got {str(value)[:40]!r}.")


def _video_of(value: object) -> str:
    """What an entry says of its video; empty: nothing."""
    found = first_value(value, COLUMN_NAMES["video"]) if isinstance(value, dict) else None
    return str(found).strip() if isinstance(found, (str, int)) else ""


def _frame_of(value: object) -> object:
    """What an entry says of its frame; None: nothing."""
    if not isinstance(value, dict):
        return None
    found = first_value(value, COLUMN_NAMES["frame"])
    return (
        first_value({normalized(name): each for name, each in value.items()}, COLUMN_NAMES["frame"])
        if found is None
        else found
    )


def sniff_tracks_json(path: Path) -> bool:
    """Whether it is, or has, a JSON of tracks or detections of this kind."""
    files = [path]
    if path.is_dir():
        found = [*path.glob("*.json"), *(f for subset in SUBSETS for f in path.glob(f"{subset}/*.json"))]
        files = sorted(f for f in found if f.name != MANIFEST)[:1]
    for file in files:
        if file.suffix.lower() != ".json":
            return False
        start = head_of(file)
        if b'"tsr-tracks"' in start:
            return True
        # Lists of Ultralytics' texts have their quotes escaped.
        start = start.lower().replace(b'\\"', b'"')
        names = {part.decode("latin-1") for part in re.findall(rb'"([a-z_0-9 .-]{1,40})"\s*:', start)}
        boxes = names & {"box", "xyxy", "bbox", "xywh", *COLUMN_NAMES["x1"]}
        foreign = names & {"image_id", "images", "dm_format_version", "framescount"} or b'"videorectangle"' in start
        frames = names & {*COLUMN_NAMES["frame"], "confidence"} or any(map(FRAME_KEY.fullmatch, names))
        return bool(boxes and frames and not foreign)
    return False
