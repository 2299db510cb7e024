"""Reads Datumaro JSON of any version."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from itertools import groupby, pairwise
from pathlib import Path

from tsr_engine.exchange.attributes import BOX_NAMES, ignore_marks, label_values, parse_attributes, track_facts
from tsr_engine.exchange.box_rules import Edges, scaled
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.file_listing import head_of, list_json_files
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.frames_of_pictures import frames_of_pictures
from tsr_engine.exchange.ids import id_of, is_number, real_of, track_of, whole_of
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.json_stream import members, read_members
from tsr_engine.exchange.picture_names import parse_picture_name
from tsr_engine.exchange.picture_sequences import ListedPicture
from tsr_engine.exchange.reading import rule_error
from tsr_engine.exchange.rotated_boxes import bounding_box
from tsr_engine.exchange.video_spellings import VideoNameMatcher
from tsr_engine.json_shapes import JsonObject

_CATEGORIES = re.compile(rb'"categories"\s*:\s*\{')
"""Older versions, and CVAT's, do not name the format; categories are an object in no other format."""
_POSITIONS_REPORT = "attr.frame is only the position in a list, so pictures got the frame of their names"


def read_datumaro(path: Path, target: ImportTarget) -> Dataset:
    """Read one file, or the files of all subsets.

    Args:
        path: a JSON file, or the folder of an export.
        target: the video that the file is about.

    Raises:
        ImportFormatError: an item or annotation breaks a rule.
    """
    validator = ImportValidator(target)
    files = list_json_files(path)
    if not files:
        raise rule_error(path.name, None, "has no annotations/*.json. Export as Datumaro again.")
    listed = [picture for file in files for picture in _listed(file, len(files) > 1)]
    _drop_positions(listed, validator)
    frames = iter(frames_of_pictures(listed, validator, path if path.is_dir() else path.parent))
    other_annotations = 0
    for file in files:
        content = read_members(file, ("categories",))
        names = _label_names(content, file.name) if content else []
        for key, position, item in members(file):
            if key != "items" or not position:
                continue
            if not content:
                _label_names(content, file.name)
            frame = next(frames)
            if frame is None:
                continue
            where = f"item {position}"
            scale = _scale(item, file.name, where, validator)
            for count, annotation in enumerate(item.get("annotations", [])):
                other_annotations += not _annotation(
                    annotation, names, frame, scale, validator, file.name, f"{where}, box {count + 1}"
                )
    if other_annotations:
        validator.skip(f"{other_annotations} annotations", "They are not boxes.")
    return validator.finish(files[0].name, interpolate=target.switches.get("interpolate") == "yes")


def _listed(file: Path, several_files: bool) -> Iterator[ListedPicture]:
    """The pictures of a file; with several files, a file's name counts as a folder's name does."""
    found = False
    for key, position, item in members(file):
        found |= key == "items" and position is not None
        if key != "items" or not position:
            continue
        where = f"item {position}"
        if not isinstance(item, dict) or not isinstance(item.get("annotations", []), list):
            raise rule_error(file.name, where, "must be an object with a list of annotations. Correct it.")
        image, attr = item.get("image"), item.get("attr")
        path = str(image.get("path", "")) if isinstance(image, dict) else ""
        name = str(item.get("id") or path)
        stated_frame = attr.get("frame") if isinstance(attr, dict) else None
        media = item.get("video_frame")
        media = media if isinstance(media, dict) else {}
        if stated_frame is None:
            stated_frame = media.get("frame_index")
        frame = None if stated_frame is None else whole_of(stated_frame, "frame", file.name, where)
        yield ListedPicture(
            f"{file.stem}/{name}" if several_files else name,
            file.name,
            where,
            fallback_name=path,
            frame=frame,
            video=str(media.get("video_path") or "").replace("\\", "/").rpartition("/")[2],
        )
    if not found:
        raise rule_error(file.name, None, "must be an object with a list of items. Export as Datumaro again.")


def _drop_positions(listed: list[ListedPicture], validator: ImportValidator) -> None:
    """Drop each ``attr.frame`` that is only the position in a list of pictures, as in CVAT's tasks of pictures."""
    video = validator.target.video
    is_video_name = VideoNameMatcher(video)
    for file, pictures in groupby(listed, key=lambda picture: picture.file):
        sequence = [(each, parse_picture_name(each.name.rpartition("/")[2], is_video_name)) for each in pictures]
        frames = [(name.number, each.frame) for each, name in sequence]
        stated = [
            (number, frame) for number, frame in frames if number is not None and frame is not None and frame >= 0
        ]
        gaps = [number - frame for number, frame in stated]
        # In a list of some frames a position is never above its frame, and falls behind with each frame left out. Names
        # of a longer video, from which this one was cut, have numbers beyond its end.
        if (
            len(stated) == len(sequence)
            and not any(each.video for each, _ in sequence)
            and len({name.pattern for _, name in sequence}) == 1
            and set(gaps) not in ({0}, {1})
            and all(a <= b for a, b in pairwise([0, *gaps]))
            and max(number for number, _ in stated) <= video.frames
        ):
            for each, _ in sequence:
                each.frame = None
                validator.count(_POSITIONS_REPORT, file, each.line)


def _label_names(content: JsonObject, file: str) -> list[str]:
    try:
        return [str(label["name"]) for label in content["categories"]["label"]["labels"]]
    except (KeyError, TypeError):
        raise rule_error(file, None, "has no categories.label.labels with names. Export as Datumaro again.") from None


def _scale(item: JsonObject, file: str, where: str, validator: ImportValidator) -> tuple[float, float]:
    image = item.get("image")
    size = image.get("size") if isinstance(image, dict) else None
    if size is None:
        return 1.0, 1.0
    video = validator.target.video
    if size == [video.height, video.width]:
        return 1.0, 1.0
    if not (isinstance(size, list) and len(size) == 2 and all(is_number(side) and abs(side) < 1e6 for side in size)):
        raise rule_error(file, where, f"image.size must be [height, width]. Got {str(size)[:60]}.")
    return validator.scale(float(size[1]), float(size[0]), file, where)


def _annotation(
    annotation: object,
    names: list[str],
    frame: int,
    scale: tuple[float, float],
    validator: ImportValidator,
    file: str,
    where: str,
) -> bool:
    """Take one annotation; False: it is not a box."""
    if not isinstance(annotation, dict):
        raise rule_error(file, where, "must be an object. Correct it.")
    if annotation.get("type") != "bbox":
        return False
    label = id_of(annotation.get("label_id"))
    if not isinstance(label, int) or not 0 <= label < len(names):
        raise rule_error(
            file, where, f"label_id {annotation.get('label_id')!r} must be 0 to {len(names) - 1}. Correct it."
        )
    attributes = annotation.get("attributes", {})
    attributes = attributes if isinstance(attributes, dict) else {}
    track = track_of(attributes.get("track_id"), "track_id", file, where)
    uid = str(attributes.get("uid", "")).strip() or (f"datumaro-{track}" if track is not None else "")
    if not uid:
        uid = validator.unique_uid(f"{frame}-{where.rsplit(' ', 1)[1]}", file, where)
    if attributes.get("outside") in (True, "true", "True"):
        # Datumaro keeps CVAT's end marks as boxes.
        validator.hide_from(uid, frame)
        return True
    marks = ignore_marks(attributes)
    # CVAT writes attributes of the kind text as texts, also an empty default.
    score = None if attributes.get("score") == "" else attributes.get("score")
    validator.box(
        uid,
        frame,
        validator.boxes.edges(
            lambda: _edges(annotation.get("bbox"), attributes.get("rotation"), scale, validator, file, where)
        ),
        validator.label(names[label], file, where),
        file=file,
        line=where,
        key=attributes.get("keyframe", True) not in (False, "false", "False"),
        occluded=attributes.get("occluded") in (True, "true", "True"),
        ignore=any(attributes.get(name) in (True, "true", "True") for name in marks),
        score=math.nan if score is None else real_of(score, "score", file, where, in_text=True),
        attributes=parse_attributes(label_values(attributes, BOX_NAMES | marks), file, where),
        facts=track_facts(attributes),
    )
    return True


def _edges(
    box: object, rotation: object, scale: tuple[float, float], validator: ImportValidator, file: str, where: str
) -> Edges:
    """Edges in px of the video; a rotated box is replaced by the upright box around it."""
    if not isinstance(box, list) or len(box) != 4 or not all(type(side) in (int, float) for side in box):
        raise rule_error(file, where, f"bbox must be four numbers x, y, width, height. Got {str(box)[:80]}.")
    x, y, width, height = (real_of(side, "bbox", file, where) for side in box)
    edges = (x, y, x + width, y + height)
    if rotation:
        edges = bounding_box(edges, real_of(rotation, "rotation", file, where, in_text=True), validator, file, where)
    return scaled(edges, scale)


def sniff_datumaro(path: Path) -> bool:
    """Whether a file or folder looks like Datumaro's."""
    for file in list_json_files(path)[:1] if path.is_dir() or path.suffix.lower() == ".json" else []:
        start = head_of(file)
        return b'"dm_format_version"' in start or _CATEGORIES.search(start) is not None
    return False
