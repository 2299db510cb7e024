"""Groups the pictures of an import into sequences, by folder and by the text before the frame number."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, NamedTuple

from tsr_engine.exchange.dataset import DatasetVideo
from tsr_engine.exchange.formats import Switch
from tsr_engine.exchange.frame_numbering import FIRST_FRAME_SWITCH, NumberingScheme
from tsr_engine.exchange.nearby_manifest import find_manifest, prefix_in_export
from tsr_engine.exchange.picture_names import PictureName, parse_picture_name
from tsr_engine.exchange.reading import MAX_JSON_BYTES
from tsr_engine.exchange.video_names import is_name_of_namesake
from tsr_engine.exchange.video_spellings import VideoNameMatcher, normalized_name

PICTURE_SWITCHES: Final = (
    FIRST_FRAME_SWITCH,
    Switch(
        "video",
        ("auto",),
        "Video whose pictures to take, by its name in the file; auto: the one that names this video.",
        free=True,
    ),
)
_GENERIC_FOLDER = re.compile(
    r"\.{1,2}|(?:train|training|val|valid|validation|test|testing|trainval)(?:\d{4})?|default|images?|labels?|annotations?|"
    r"jpegimages|imagesets|voc\d{4}|obj_.+_data|img1?|imgs|frames?|pictures?|data|dataset",
    re.IGNORECASE,
)
"""Folders that belong to a format or a split."""
_ADDRESS_PREFIX = re.compile(r".*(?:[?&]d=|/upload/\d+/)")
"""Label Studio's prefix of an address."""
_VOC_FLAG = re.compile(r"\s+(?:-?1|0)\s*\Z")
"""Suffixes of Pascal VOC's lists of one class."""
_QUERY = re.compile(r"\?[^/]*\Z")
_EXPORT_SCHEMES = (
    NumberingScheme(0, prefix_pattern=r"(?:.+_)?frame_", digits=6),
    NumberingScheme(0, prefix_pattern="", digits=5),
)
"""Names in our own exports; the second form is that of GTSDB."""
_KNOWN_SCHEMES = (
    _EXPORT_SCHEMES[0],
    NumberingScheme(
        1, "pictures in folders img1 begin with 000001, as the MOT challenge has them", prefix_pattern="img1/", digits=6
    ),
)
_ROBOFLOW_SCHEME = NumberingScheme(
    0, "Roboflow counts the pictures that it extracts from a video from 0; they are its frames if it took every one"
)


@dataclass(slots=True)
class ListedPicture:
    """A picture that a file lists.

    Attributes:
        name: with folders, as in the file.
        file: for messages.
        line: place in the file.
        fallback_name: another name, used if the first has no number.
        frame: the ordinal, if the file states it.
        number: the frame number, if the file states one beside the name.
        scheme: how ``number`` counts; without ``number``, how the format's own tool counts in names that it writes.
        video: the file's name for the picture's video; may be empty.
        task_name: another name of the video, used only if it is that of the import's video.
        is_of_video: whether the picture is of the import's video, if a hash in the file says so; None: no hash.
    """

    name: str
    file: str
    line: int | str | None = None
    fallback_name: str = ""
    frame: int | None = None
    number: int | None = None
    scheme: NumberingScheme | None = None
    video: str = ""
    task_name: str = ""
    is_of_video: bool | None = None


class UnnumberedPicture(NamedTuple):
    """A picture without a frame: its index, the reason, and whether it is of the import's video."""

    position: int
    reason: str
    is_of_video: bool


@dataclass(slots=True, eq=False)
class PictureSequence:
    """Pictures with the same folder and text before the number.

    Attributes:
        first: the first picture.
        name: the parsed name of the first picture.
        label: name of their video; empty: none.
        folder: their folders without those of formats.
        is_of_video: whether they name the import's video.
        is_of_other_video: whether they are certainly of another video.
        is_certain: whether a hash or a manifest of ours decides this.
        is_stated: whether the file names the import's video outside the picture names.
        schemes: tools that may have written the names.
        prefix: the text before the number.
        indices: indices of the pictures.
        numbers: of each picture, from 0 or 1; empty if frames or seconds are known.
        frames: ordinal of each picture.
        seconds: time of each picture.
        widths: digits of the numbers, and whether the first of several digits is a zero.
        span: smallest and largest number, including pictures that only a list names.
        numbers_in_names: whether the numbers beside the names equal those in the names, which may count differently.
    """

    first: ListedPicture
    name: PictureName
    label: str
    folder: tuple[str, ...]
    is_of_video: bool
    is_of_other_video: bool
    is_certain: bool
    is_stated: bool
    schemes: tuple[NumberingScheme, ...]
    prefix: str
    indices: list[int] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    widths: set[tuple[int, bool]] = field(default_factory=set)
    span: tuple[int, int] = (0, 0)
    numbers_in_names: bool = True

    @property
    def other_name(self) -> str:
        """The name of their video if it is another one; empty: it is the import's, or they name none."""
        return "" if self.is_stated or (self.is_of_video and not self.first.video) else self.label

    @property
    def display_name(self) -> str:
        """The name of the sequence in messages."""
        return self.label or self.first.task_name or self.name.pattern or "pictures whose names are numbers"

    @property
    def selectable_names(self) -> set[str]:
        """Normalized names by which a person may choose the sequence."""
        names = (self.label, self.first.task_name, self.name.pattern, "/".join(self.folder), *self.folder[-1:])
        return {normalized_name(name) for name in names} - {""}

    @property
    def number_kind(self) -> str:
        """What its numbers are, for messages."""
        return "frame ids" if self.first.number is not None else "the numbers in picture names"

    def scheme(self) -> NumberingScheme | None:
        """How the tool that wrote the numbers counts; None: many tools write such names."""
        if self.first.number is not None:
            scheme = self.first.scheme
            return None if self.numbers_in_names and scheme is not None and not scheme.origin else scheme
        if self.name.roboflow:
            return _ROBOFLOW_SCHEME
        return next((scheme for scheme in self.schemes if scheme.matches(self.prefix, self.widths)), None)


def group_pictures(
    listed: Sequence[ListedPicture], video: DatasetVideo, folder: Path, listed_names: Iterable[str] = ()
) -> tuple[list[PictureSequence], list[UnnumberedPicture], list[tuple[int, str]]]:
    """Return the sequences of all pictures, the pictures without a frame, and notes on differences by index.

    Args:
        listed: the pictures.
        video: the import's video.
        folder: the import's folder; a manifest of ours beside it says which names are of the video.
        listed_names: names of pictures without boxes, from a list beside the boxes.
    """
    grouping = _Grouping(video, folder)
    for index, picture in enumerate(listed):
        grouping.add(index, picture)
    grouping.widen_spans(listed_names)
    return list(grouping.sequences.values()), grouping.unnumbered, grouping.differences


class _Grouping:
    """Puts pictures into sequences."""

    def __init__(self, video: DatasetVideo, folder: Path) -> None:
        self._video = video
        self._is_video_name = VideoNameMatcher(video)
        self._prefix = prefix_in_export(folder, video)
        self._in_own_export = find_manifest(folder) is not None
        self._folders: dict[str, tuple[tuple[str, ...], bool, bool]] = {}
        self.sequences: dict[tuple[object, ...], PictureSequence] = {}
        self.unnumbered: list[UnnumberedPicture] = []
        self.differences: list[tuple[int, str]] = []

    def add(self, index: int, picture: ListedPicture) -> None:
        """Add a picture."""
        parent, base = _split_address(picture.name)
        folder, in_video_folder, in_img1 = self._inspect_folder(parent)
        is_of_video = picture.is_of_video
        if self._prefix and is_of_video is None:
            is_of_video = base.startswith(self._prefix)
            base = base[len(self._prefix) :] if is_of_video else base
        name = parse_picture_name(base, self._is_video_name)
        if picture.fallback_name:
            fallback = parse_picture_name(_split_address(picture.fallback_name)[1], self._is_video_name)
            if name.number is None and name.seconds is None:
                name = name if fallback.number is None and fallback.seconds is None else fallback
            elif fallback.number not in (None, name.number):
                self.differences.append((index, "Files that name another frame inside were imported by their own name"))
        is_own_export = _EXPORT_SCHEMES[0].matches(name.pattern, {name.width})
        if is_own_export and picture.frame is not None and name.number != picture.frame:
            self.differences.append((index, "Pictures got the frame that the file states, not that of their names"))
        number_in_name = picture.number == name.number and not is_own_export
        is_stated = picture.frame is not None or picture.number is not None
        if is_stated and not (name.stem and (name.pattern.endswith("_frame_") or self._is_video_name(name.stem))):
            # This number is not needed, and any text may stand before it.
            name = PictureName()
        if not is_stated and name.number is None and name.seconds is None:
            names_video = is_of_video is not False and (
                bool(is_of_video) or in_video_folder or self._is_video_name(picture.video)
            )
            self.unnumbered.append(UnnumberedPicture(index, name.reason, names_video))
            return
        if self._is_video_name(name.stem):
            # Folders may be parts of one video; they decide only if names do not.
            folder = ()
        statements = (picture.video, picture.task_name, picture.frame is None, picture.number is None)
        key = (folder, name.pattern, name.roboflow, in_img1, is_of_video, statements)
        sequence = self.sequences.get(key)
        if sequence is None:
            sequence = self.sequences[key] = self._make_sequence(
                picture, name, folder, in_video_folder, in_img1, is_of_video
            )
        sequence.indices.append(index)
        if picture.frame is not None:
            sequence.frames.append(picture.frame)
        elif picture.number is not None:
            sequence.numbers.append(picture.number)
            sequence.numbers_in_names &= number_in_name
        elif name.seconds is not None:
            sequence.seconds.append(name.seconds)
        elif name.number is not None:
            sequence.numbers.append(name.number)
            sequence.widths.add(name.width)

    def widen_spans(self, listed_names: Iterable[str]) -> None:
        """Widen the span of each sequence by the names of a list."""
        by_pattern: dict[str, list[PictureSequence]] = {}
        for sequence in self.sequences.values():
            if sequence.numbers:
                sequence.span = min(sequence.numbers), max(sequence.numbers)
                if sequence.widths:
                    by_pattern.setdefault(sequence.name.pattern, []).append(sequence)
        for text in listed_names:
            name = parse_picture_name(_split_address(text)[1].removeprefix(self._prefix), self._is_video_name)
            matching = by_pattern.get(name.pattern, ())
            # Sequences of two videos can share a pattern.
            if name.number is not None and len(matching) == 1:
                matching[0].span = min(matching[0].span[0], name.number), max(matching[0].span[1], name.number)

    def _inspect_folder(self, parent: str) -> tuple[tuple[str, ...], bool, bool]:
        """The informative folders, whether one has the video's name, and whether the last is ``img1``."""
        found = self._folders.get(parent)
        if found is None:
            parts = [part for part in parent.split("/") if part]
            informative = tuple(part for part in parts if not _GENERIC_FOLDER.fullmatch(part))
            found = self._folders[parent] = informative, any(map(self._is_video_name, parts)), parts[-1:] == ["img1"]
        return found

    def _make_sequence(
        self,
        picture: ListedPicture,
        name: PictureName,
        folder: tuple[str, ...],
        in_video_folder: bool,
        in_img1: bool,
        is_of_video: bool | None,
    ) -> PictureSequence:
        is_stated = is_of_video is True or self._is_video_name(picture.video) or self._is_video_name(picture.task_name)
        is_namesake = (
            is_of_video is None and name.pattern.endswith("_frame_") and is_name_of_namesake(name.stem, self._video)
        )
        by_name = self._is_video_name(name.stem) if name.stem else in_video_folder
        return PictureSequence(
            first=picture,
            name=name,
            label=picture.video or name.stem or "".join(folder[-1:]),
            folder=folder,
            is_of_video=is_of_video is not False and not is_namesake and (is_stated or by_name),
            is_of_other_video=is_of_video is False or is_namesake,
            is_certain=is_of_video is not None,
            is_stated=is_stated,
            schemes=(
                *(_EXPORT_SCHEMES if self._in_own_export else ()),
                *_KNOWN_SCHEMES,
                *([picture.scheme] if picture.scheme else []),
            ),
            prefix=f"img1/{name.pattern}" if in_img1 else name.pattern,
        )


def read_picture_list(path: Path) -> list[str]:
    """Picture names in a list, one per line; empty if the file does not exist."""
    if not path.is_file() or path.stat().st_size > MAX_JSON_BYTES:
        return []
    lines = path.read_bytes().decode("utf-8", "replace").splitlines()
    return [_VOC_FLAG.sub("", line).strip() for line in lines if line.strip()]


def _split_address(name: str) -> tuple[str, str]:
    """Folders and name of a picture, without a server's additions to the address."""
    name = name.replace("\\", "/")
    if "?" in name or "/upload/" in name:
        name = _QUERY.sub("", _ADDRESS_PREFIX.sub("", name))
    parent, _, base = name.rpartition("/")
    return parent, base
