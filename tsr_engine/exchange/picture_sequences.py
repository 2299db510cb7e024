"""Groups the pictures of an import into rows, by folder and by the text before the frame number."""

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

__all__ = [
    "PICTURE_SWITCHES",
    "ListedPicture",
    "PictureSequence",
    "UnnumberedPicture",
    "group_pictures",
    "read_picture_list",
]

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
    r"jpegimages|imagesets|voc\d{4}|obj_(?:train|valid|test)_data|img1?|imgs|frames?|pictures?|data|dataset",
    re.IGNORECASE,
)
"""Folders that belong to a format or a split."""
_ADDRESS_PREFIX = re.compile(r".*(?:[?&]d=|/upload/\d+/)")
"""Label Studio's prefix of an address."""
_VOC_FLAG = re.compile(r"\s+(?:-?1|0)\s*\Z")
"""Suffixes of Pascal VOC's lists of one class."""
_QUERY = re.compile(r"\?[^/]*\Z")
_EXPORT_SCHEMES = (NumberingScheme(0, before=r"(?:.+_)?frame_", digits=6), NumberingScheme(0, before="", digits=5))
"""Names in our own exports; the second form is that of GTSDB."""
_KNOWN_SCHEMES = (
    _EXPORT_SCHEMES[0],
    NumberingScheme(
        1, "pictures in folders img1 begin with 000001, as the MOT challenge has them", before="img1/", digits=6
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
        instead: another name, used if the first has no number.
        frame: the ordinal, if the file states it.
        number: the frame number, if the file states one beside the name.
        custom: how ``number`` counts; without ``number``, how the format's own tool counts in names that it writes.
        video: the file's name for the picture's video; may be empty.
        also: another name of the video, used only if it is that of the import's video.
        own: whether the picture is of the import's video, if a hash in the file says so; None: no hash.
    """

    name: str
    file: str
    line: int | str | None = None
    instead: str = ""
    frame: int | None = None
    number: int | None = None
    custom: NumberingScheme | None = None
    video: str = ""
    also: str = ""
    own: bool | None = None


class UnnumberedPicture(NamedTuple):
    """A picture without a frame: its index, the reason, and whether it is of the import's video."""

    place: int
    why: str
    own: bool


@dataclass(slots=True, eq=False)
class PictureSequence:
    """Pictures with the same folder and text before the number.

    Attributes:
        first: the first picture.
        name: the parsed name of the first picture.
        label: name of their video; empty: none.
        folder: their folders without those of formats.
        own: whether they name the import's video.
        other: whether they are certainly of another video.
        certain: whether a hash or a manifest of ours decides this.
        stated: whether the file names the import's video outside the picture names.
        customs: tools that may have written the names.
        before: the text before the number.
        places: indices of the pictures.
        numbers: of each picture, from 0 or 1; empty if frames or seconds are known.
        frames: ordinal of each picture.
        seconds: time of each picture.
        widths: digits of the numbers, and whether the first of several digits is a zero.
        span: smallest and largest number, including pictures that only a list names.
        echoed: whether the numbers beside the names equal those in the names, which may count differently.
    """

    first: ListedPicture
    name: PictureName
    label: str
    folder: tuple[str, ...]
    own: bool
    other: bool
    certain: bool
    stated: bool
    customs: tuple[NumberingScheme, ...]
    before: str
    places: list[int] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    widths: set[tuple[int, bool]] = field(default_factory=set)
    span: tuple[int, int] = (0, 0)
    echoed: bool = True

    @property
    def other_name(self) -> str:
        """The name of their video if it is another one; empty: it is the import's, or they name none."""
        return "" if self.stated or (self.own and not self.first.video) else self.label

    @property
    def shown(self) -> str:
        """The row's name in messages."""
        return self.label or self.first.also or self.name.pattern or "pictures whose names are numbers"

    @property
    def called(self) -> set[str]:
        """Plain names by which a person may choose the row."""
        names = (self.label, self.first.also, self.name.pattern, "/".join(self.folder), *self.folder[-1:])
        return {normalized_name(name) for name in names} - {""}

    @property
    def what(self) -> str:
        """What its numbers are, for messages."""
        return "frame ids" if self.first.number is not None else "the numbers in picture names"

    def custom(self) -> NumberingScheme | None:
        """How the tool that wrote the numbers counts; None: many tools write such names."""
        if self.first.number is not None:
            custom = self.first.custom
            return None if self.echoed and custom is not None and not custom.origin else custom
        if self.name.roboflow:
            return _ROBOFLOW_SCHEME
        return next((custom for custom in self.customs if custom.wrote(self.before, self.widths)), None)


def group_pictures(
    listed: Sequence[ListedPicture], video: DatasetVideo, folder: Path, more: Iterable[str] = ()
) -> tuple[list[PictureSequence], list[UnnumberedPicture], list[tuple[int, str]]]:
    """Return the rows of all pictures, the pictures without a frame, and notes on differences by index.

    Args:
        listed: the pictures.
        video: the import's video.
        folder: the import's folder; a manifest of ours beside it says which names are of the video.
        more: names of pictures without boxes, from a list beside the boxes.
    """
    maker = _Grouping(video, folder)
    for place, each in enumerate(listed):
        maker.add(place, each)
    maker.widen(more)
    return list(maker.rows.values()), maker.nameless, maker.differ


class _Grouping:
    """Puts pictures into rows."""

    def __init__(self, video: DatasetVideo, folder: Path) -> None:
        self._video = video
        self._is_own = VideoNameMatcher(video)
        self._prefix = prefix_in_export(folder, video)
        self._in_ours = find_manifest(folder) is not None
        self._folders: dict[str, tuple[tuple[str, ...], bool, bool]] = {}
        self.rows: dict[tuple[object, ...], PictureSequence] = {}
        self.nameless: list[UnnumberedPicture] = []
        self.differ: list[tuple[int, str]] = []

    def add(self, place: int, each: ListedPicture) -> None:
        """Add a picture."""
        home, base = _split_address(each.name)
        folder, in_own, in_img1 = self._folder(home)
        own = each.own
        if self._prefix and own is None:
            own = base.startswith(self._prefix)
            base = base[len(self._prefix) :] if own else base
        name = parse_picture_name(base, self._is_own)
        if each.instead:
            other = parse_picture_name(_split_address(each.instead)[1], self._is_own)
            if name.number is None and name.seconds is None:
                name = name if other.number is None and other.seconds is None else other
            elif other.number not in (None, name.number):
                self.differ.append((place, "Files that name another frame inside were imported by their own name"))
        from_0 = _EXPORT_SCHEMES[0].wrote(name.pattern, {name.width})
        if from_0 and each.frame is not None and name.number != each.frame:
            self.differ.append((place, "Pictures got the frame that the file states, not that of their names"))
        echoed = each.number == name.number and not from_0
        known = each.frame is not None or each.number is not None
        if known and not (name.stem and (name.pattern.endswith("_frame_") or self._is_own(name.stem))):
            # This number is not needed, and any text may stand before it.
            name = PictureName()
        if not known and name.number is None and name.seconds is None:
            ours = own is not False and (bool(own) or in_own or self._is_own(each.video))
            self.nameless.append(UnnumberedPicture(place, name.why, ours))
            return
        if self._is_own(name.stem):
            # Folders may be parts of one video; they decide only if names do not.
            folder = ()
        said = (each.video, each.also, each.frame is None, each.number is None)
        key = (folder, name.pattern, name.roboflow, in_img1, own, said)
        row = self.rows.get(key)
        if row is None:
            row = self.rows[key] = self._row(each, name, folder, in_own, in_img1, own)
        row.places.append(place)
        if each.frame is not None:
            row.frames.append(each.frame)
        elif each.number is not None:
            row.numbers.append(each.number)
            row.echoed &= echoed
        elif name.seconds is not None:
            row.seconds.append(name.seconds)
        elif name.number is not None:
            row.numbers.append(name.number)
            row.widths.add(name.width)

    def widen(self, more: Iterable[str]) -> None:
        """Widen the span of each row by the names of a list."""
        by_pattern: dict[str, list[PictureSequence]] = {}
        for row in self.rows.values():
            if row.numbers:
                row.span = min(row.numbers), max(row.numbers)
                if row.widths:
                    by_pattern.setdefault(row.name.pattern, []).append(row)
        for text in more:
            name = parse_picture_name(_split_address(text)[1].removeprefix(self._prefix), self._is_own)
            rows = by_pattern.get(name.pattern, ())
            # Rows of two videos can share a pattern.
            if name.number is not None and len(rows) == 1:
                rows[0].span = min(rows[0].span[0], name.number), max(rows[0].span[1], name.number)

    def _folder(self, home: str) -> tuple[tuple[str, ...], bool, bool]:
        """The informative folders, whether one has the video's name, and whether the last is ``img1``."""
        found = self._folders.get(home)
        if found is None:
            parts = [part for part in home.split("/") if part]
            said = tuple(part for part in parts if not _GENERIC_FOLDER.fullmatch(part))
            found = self._folders[home] = said, any(map(self._is_own, parts)), parts[-1:] == ["img1"]
        return found

    def _row(
        self,
        each: ListedPicture,
        name: PictureName,
        folder: tuple[str, ...],
        in_own: bool,
        in_img1: bool,
        own: bool | None,
    ) -> PictureSequence:
        stated = own is True or self._is_own(each.video) or self._is_own(each.also)
        twin = own is None and name.pattern.endswith("_frame_") and is_name_of_namesake(name.stem, self._video)
        by_name = self._is_own(name.stem) if name.stem else in_own
        return PictureSequence(
            first=each,
            name=name,
            label=each.video or name.stem or "".join(folder[-1:]),
            folder=folder,
            own=own is not False and not twin and (stated or by_name),
            other=own is False or twin,
            certain=own is not None,
            stated=stated,
            customs=(
                *(_EXPORT_SCHEMES if self._in_ours else ()),
                *_KNOWN_SCHEMES,
                *([each.custom] if each.custom else []),
            ),
            before=f"img1/{name.pattern}" if in_img1 else name.pattern,
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
    home, _, base = name.rpartition("/")
    return home, base
