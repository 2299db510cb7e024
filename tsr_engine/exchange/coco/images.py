"""Reads the images, categories and videos of COCO files, and finds the frame of each image."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.dataset import DatasetVideo
from tsr_engine.exchange.frame_numbering import NumberingScheme
from tsr_engine.exchange.frames_of_pictures import frames_of_pictures
from tsr_engine.exchange.ids import id_of, is_number, real_of, whole_of
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.json_stream import members
from tsr_engine.exchange.picture_sequences import ListedPicture
from tsr_engine.exchange.reading import rule_error
from tsr_engine.json_shapes import JsonObject

_SINGULAR: Final = {"categories": "category", "images": "image", "videos": "video"}
_IMAGE_KEYS: Final = (
    *("id", "file_name", "frame", "frame_id", "frame_index", "prev_image_id"),
    *("width", "height", "video", "video_id", "video_sha256"),
)
_COCO_VID = NumberingScheme(0, "CocoVID counts frame_id from 0")
_PREV_IMAGE_ID = NumberingScheme(1, "files whose images have prev_image_id count frame_id from 1")


@dataclass(slots=True)
class Image:
    """An image of the video: its frame, and the factors from its size to the video's."""

    frame: int
    scale: tuple[float, float]


@dataclass(slots=True)
class CocoHead:
    """The content of a file besides its annotations.

    Attributes:
        file: its name.
        categories: names by id.
        videos: as in the file, by id.
        listed: the images, reduced to what is needed, since a file can have 100,000.
        images: by id; None: of another video.
    """

    file: str
    categories: dict[object, str] = field(default_factory=dict)
    videos: dict[object, JsonObject] = field(default_factory=dict)
    listed: list[JsonObject] = field(default_factory=list)
    images: dict[object, Image | None] = field(default_factory=dict)


def read_head(path: Path, name: str) -> CocoHead | None:
    """Read a file except its annotations; None: the file is a list of results.

    Args:
        path: the file.
        name: the file's name for messages.

    Raises:
        ImportFormatError: images or categories are missing, or an id is missing or occurs twice.
    """
    head = CocoHead(name)
    found_keys: set[str] = set()
    texts: dict[str, str] = {}
    # Any: a name, an object of JSON or None, by table
    tables: dict[str, dict[object, Any]] = {"categories": head.categories, "images": head.images, "videos": head.videos}
    for key, position, value in members(path, name=name):
        if key == "":
            if position is None:
                rule = "must be an object with images, categories and annotations, or a list of results."
                raise rule_error(name, None, rule)
            return None
        if key not in _SINGULAR:
            in_videos = "videos" not in found_keys and any("video_id" in image for image in head.listed)
            if {"categories", "images"} <= found_keys and not in_videos:
                break
            continue
        if position is None or (position and not isinstance(value, dict)):
            raise missing_list_error(name, key)
        found_keys.add(key)
        if not position:
            continue
        where = f"{_SINGULAR[key]} {position}"
        number = _required_id(value.get("id"), name, where)
        table = tables[key]
        if number in table:
            raise rule_error(name, where, f"the id {number} occurs twice. Give each a unique id.")
        table[number] = str(value.get("name", "")) if key == "categories" else value if key == "videos" else None
        if key == "images":
            image = {kept: value[kept] for kept in _IMAGE_KEYS if kept in value}
            if isinstance(image.get("video_sha256"), str):
                # one object for all equal hashes
                image["video_sha256"] = texts.setdefault(image["video_sha256"], image["video_sha256"])
            head.listed.append(image)
    for key in ("categories", "images"):
        if key not in found_keys:
            raise missing_list_error(name, key)
    return head


def missing_list_error(file: str, key: str) -> ImportFormatError:
    """The error for a list that is missing or is not a list of objects."""
    return rule_error(file, None, f"must have {key}, a list of objects. Export as COCO again.")


def _required_id(value: object, file: str, where: str) -> int | str:
    """A required id.

    Raises:
        ImportFormatError: it is missing or not an id.
    """
    found = id_of(value)
    if found is None:
        raise rule_error(file, where, f"id must be a whole number. Got {str(value)[:40]!r}.")
    return found


def find_image_frames(heads: Sequence[CocoHead], validator: ImportValidator, folder: Path) -> None:
    """Find the frame of each image, once all files are known.

    Args:
        heads: heads of the files; fills ``images`` and empties ``listed``.
        validator: takes the reports.
        folder: the import's folder.

    Raises:
        ImportFormatError: an image has another size than the video, or as ``frames_of_pictures``.
    """
    video = validator.target.video
    hashes = {str(image.get("video_sha256") or "") for head in heads for image in head.listed} - {""}
    listed = [
        _listed(image, f"image {position}", head, hashes, video, len(heads) > 1)
        for head in heads
        for position, image in enumerate(head.listed, start=1)
    ]
    if hashes and video.sha256 and video.sha256 not in hashes:
        validator.repair(f"{heads[0].file}: names another file than {video.name} by its hash. It was imported anyway.")
    frames = iter(frames_of_pictures(listed, validator, folder))
    for head in heads:
        chosen: dict[object, JsonObject] = {}
        for position, image in enumerate(head.listed, start=1):
            frame = next(frames)
            if frame is not None:
                scale = _scale(image, head, f"image {position}", validator)
                head.images[id_of(image["id"])] = Image(frame, scale)
                key = id_of(image.get("video_id"))
                chosen[key] = head.videos.get(key, {})
        head.listed.clear()
        for info in chosen.values():
            # With another rate the frames were counted after others were left out.
            name = next((name for name in ("annotation_fps", "fps") if is_number(info.get(name))), None)
            if name is not None:
                validator.check_rate(real_of(info[name], name, head.file, "videos"), head.file)


def _listed(
    image: JsonObject, where: str, head: CocoHead, hashes: set[str], video: DatasetVideo, several_files: bool
) -> ListedPicture:
    stated = {name: image[name] for name in ("frame", "frame_id", "frame_index") if image.get(name) is not None}
    numbers = {name: whole_of(value, name, head.file, where) for name, value in stated.items()}
    digest = str(image.get("video_sha256") or "")
    is_of_video = digest == video.sha256 if digest and video.sha256 in hashes else None
    video_name = _video_name(image, head, where)
    if digest and is_of_video is None and len(hashes) > 1:
        video_name = f"{video_name} ({digest[:8]})"
    name = str(image.get("file_name", ""))
    return ListedPicture(
        f"{_video_in_file_name(head.file)}/{name}" if several_files else name,
        head.file,
        where,
        frame=numbers.get("frame"),
        number=numbers.get("frame_id", numbers.get("frame_index")),
        scheme=(_PREV_IMAGE_ID if "prev_image_id" in image else _COCO_VID) if numbers else None,
        video=video_name,
        is_of_video=is_of_video,
    )


def _video_in_file_name(file: str) -> str:
    """The part of a file's name that may name a video; used if there are several files, as a folder's name is."""
    folder, _, name = file.rpartition("/")
    stem = name.removesuffix(".json").removesuffix(".coco").strip("_")
    for start in ("instances_", "person_keypoints_", "captions_", "image_info_", "labels_", "annotations_"):
        stem = stem.removeprefix(start)
    return f"{folder}/{stem}"


def _video_name(image: JsonObject, head: CocoHead, where: str) -> str:
    """The file's name for the video of an image; empty: none."""
    name = image.get("video")
    if image.get("video_id") is not None:
        key = _required_id(image["video_id"], head.file, where)
        if head.videos and key not in head.videos:
            raise rule_error(head.file, where, f"video_id {str(key)[:40]!r} matches no video of the file. Correct it.")
        info = head.videos.get(key, {})
        name = info.get("name") or info.get("file_name") or name or f"video {key}"
    parts = [part for part in str(name or "").replace("\\", "/").split("/") if part and part != "img1"]
    return parts[-1] if parts else ""


def _scale(image: JsonObject, head: CocoHead, where: str, validator: ImportValidator) -> tuple[float, float]:
    """Factors from the size of an image, or of its video in the file, to the video's size."""
    key = id_of(image.get("video_id"))
    for sized in (image, head.videos.get(key, {})):
        size = sized.get("width"), sized.get("height")
        if size not in ((None, None), (0, 0)):
            width, height = (real_of(side, "width and height", head.file, where) for side in size)
            return validator.scale(width, height, head.file, where)
    return 1.0, 1.0
