"""Finds the video that another tool's file is about by names and addresses in it, and chooses among several.

Label Studio has addresses (``/data/upload/3/1a2b3c4d-drive.mp4``, ``/data/local-files/?d=dir/drive.mp4``, signed
cloud addresses), CVAT has the file's name, and tables have a column with either. Label Studio's uploads get a prefix
of eight hexadecimal UUID digits and a dash, and lose the characters that Django's ``get_valid_filename`` removes.
"""

from __future__ import annotations

import base64
import binascii
import re
import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, Literal, TypeVar
from urllib.parse import unquote, unquote_plus, urlsplit

from tsr_engine.exchange.dataset import DatasetVideo
from tsr_engine.exchange.formats import Switch
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.reading import rule_error
from tsr_engine.exchange.video_names import is_name_of, safe_stem
from tsr_engine.plural import plural

TASK_SWITCH = Switch(
    "task",
    ("auto",),
    "Task of a file with several, by its id or the name of its video; auto: the one that names this video.",
    free=True,
)
SAME_NAME = 2
"""The name is the video's."""
SIMILAR_NAME = 1
"""The name may be a tool's version of the video's: another suffix, special characters, or digits before it."""

_SUFFIXES = "mp4|m4v|mov|avi|mkv|webm|ts|mts|m2ts|mpe?g|flv|wmv|3gp|ogv|h26[45]|hevc|gif|apng|webp"
_VIDEO_SUFFIX = re.compile(rf"\.(?:{_SUFFIXES})\Z", re.I)
_UPLOAD_PREFIX = re.compile(r"[0-9a-f]{8}-", re.ASCII)
_DISPOSITION = re.compile(r"""filename\*?=(?:UTF-8'')?["']?([^"';]+)""", re.I)
_REMOVED_CHARACTERS = re.compile(r"[^-\w.]")

Content = TypeVar("Content")


@dataclass(frozen=True, slots=True)
class VideoPart(Generic[Content]):
    """A part of a file that is about one video.

    Attributes:
        content: for the reader.
        addresses: names and addresses of its video in the file; the first is reported.
        ids: other names by which a person can choose it.
        is_match: whether it is about the video, if a hash or the like says so; None: nothing says so.
    """

    content: Content
    addresses: tuple[str, ...]
    ids: tuple[str, ...] = ()
    is_match: bool | None = None

    @property
    def name(self) -> str:
        """The name of its video, for messages; may be empty."""
        return next((name_in(address) for address in self.addresses if address), "")


def name_similarity(address: str, video: DatasetVideo) -> int:
    """How well an address fits a video: ``SAME_NAME``, ``SIMILAR_NAME``, or 0 for another video."""
    video_name = _normalized(video.name)
    best = 0
    for name, uploaded in _file_names(address):
        if _normalized(name) == video_name:
            return SAME_NAME
        prefix = _UPLOAD_PREFIX.match(name)
        # Eight digits before a name without folder may be a date.
        has_upload_prefix = prefix is not None and (uploaded or not prefix[0][:-1].isdigit())
        for each in (name, name[9:]) if has_upload_prefix else (name,):
            stem = _stem(each)
            is_export_name = is_name_of(stem, video) and stem.casefold() != safe_stem(video.name).casefold()
            if is_export_name or _upload_forms(stem, "NFC") & _upload_forms(_stem(video.name), "NFC", "NFD"):
                best = SIMILAR_NAME
    return best


def is_video(name: str) -> bool:
    """Whether a name has a video suffix."""
    return _VIDEO_SUFFIX.search(name.strip()) is not None


def name_in(address: str) -> str:
    """The file name in an address, without the digits of an upload."""
    names = list(_file_names(address))
    # An escaped name, or one with a query before it, is longer than the video's.
    name, uploaded = min(
        (each for each in names if _VIDEO_SUFFIX.search(each[0])), key=lambda each: len(each[0]), default=names[0]
    )
    return name[9:] if uploaded and _UPLOAD_PREFIX.match(name) else name


def choose_parts(
    parts: Sequence[VideoPart[Content]], validator: ImportValidator, file: str, kind: str, *, merge: bool = False
) -> list[VideoPart[Content]]:
    """The parts of a file that are about the import's video; the others are reported.

    A single part that names another video, or one chosen by a person, is taken and reported.

    Args:
        parts: of the file.
        validator: takes the reports; has the video and the switch ``task``.
        file: for messages.
        kind: the word for a part: ``task``.
        merge: whether several parts may be about one video.

    Raises:
        ImportFormatError: no part is about the video, or the choice is ambiguous.
    """
    video = validator.target.video
    option = validator.target.switches.get("task", "auto")
    if option != "auto":
        found = [part for part in parts if option in part.ids]
        found = found or [part for part in parts if any(_is_named(address, option) for address in part.addresses)]
        wanted = f"is or names {option!r}, as task={option} asks for"
    elif len(parts) <= 1:
        found, wanted = list(parts), ""
    else:
        similarities = [_part_similarity(part, video) for part in parts]
        best = max(similarities)
        found = (
            [part for part, similarity in zip(parts, similarities, strict=True) if similarity == best] if best else []
        )
        wanted = f"about {video.name}"
    if not found and parts:
        intro = "none " if option == "auto" else "none that "
        raise rule_error(
            file,
            None,
            f"has {plural(len(parts), kind)}, {intro}{wanted}: {_listed(parts)}. Choose one with task=ID or task=NAME, "
            "or the right video.",
        )
    if len(found) > 1 and not merge:
        raise rule_error(
            file,
            None,
            f"has {len(found)} {kind}s that fit {video.name if option == 'auto' else repr(option)}: {_listed(found)}. "
            "Choose one with task=ID, or export the one alone.",
        )
    others = [part for part in parts if part not in found]
    if others:
        reason = "Another one was asked for" if option != "auto" else f"They are not about {video.name}"
        validator.skip(f"{file}: {plural(len(others), kind)}", f"{reason}: {_listed(others)}.")
    for part in found:
        if part.is_match is False and name_similarity(part.name, video):
            validator.repair(
                f"{file}: names another file called {part.name[:80]}, by its hash. It was imported anyway."
            )
        elif part.name and not _part_similarity(part, video):
            validator.repair(f"{file}: names {part.name[:80]}. It was imported onto {video.name}.")
    return found


def _part_similarity(part: VideoPart[Content], video: DatasetVideo) -> int:
    if part.is_match is not None:
        return SAME_NAME + 1 if part.is_match else 0
    return max((name_similarity(address, video) for address in part.addresses), default=0)


def _listed(parts: Sequence[VideoPart[Content]]) -> str:
    names = []
    for part in parts[:8]:
        name, first = part.name or "no name", part.ids[0] if part.ids else ""
        names.append((f"{first} ({name})" if first and first != name else name)[:80])
    more = f" and {len(parts) - 8} more" if len(parts) > 8 else ""
    return ", ".join(names) + more


def _is_named(address: str, wanted_name: str) -> bool:
    wanted = {_normalized(wanted_name), _stem(_normalized(wanted_name))}
    return any(
        {_normalized(each), _stem(_normalized(each))} & wanted
        for name, _ in _file_names(address)
        for each in (name, name[9:] if _UPLOAD_PREFIX.match(name) else name)
    )


def _file_names(address: str) -> Iterator[tuple[str, bool]]:
    """File names that an address may mean, and whether each is that of an upload; at least one."""
    text = address.strip().replace("\\", "/")
    uploaded = "/upload/" in text
    tail = text.rstrip("/").rsplit("/", 1)[-1]
    yield tail, uploaded
    if "%" in tail or "+" in tail:
        yield unquote(tail), uploaded
        yield unquote_plus(tail), uploaded
    try:
        parts = urlsplit(text)
    except ValueError:
        return
    path = unquote(parts.path).rstrip("/").rsplit("/", 1)[-1]
    if path and path != tail:
        yield path, uploaded
    if _VIDEO_SUFFIX.search(path):
        return
    # An unescaped number sign is part of the name.
    for part in text.partition("?")[2].split("&"):
        key, _, value = part.partition("=")
        for decoded in dict.fromkeys((unquote_plus(value), unquote(value), value)):
            inner = _decode_address(decoded) if key == "fileuri" else decoded
            disposition = _DISPOSITION.search(inner)
            inner = disposition[1] if disposition else inner
            name = inner.replace("\\", "/").split("?", 1)[0].rstrip("/").rsplit("/", 1)[-1]
            if _VIDEO_SUFFIX.search(name):
                yield name, uploaded


def _decode_address(value: str) -> str:
    """The base-64 address in Label Studio's ``/presign/?fileuri=``; ``value`` if it is not base 64."""
    try:
        return base64.urlsafe_b64decode(value + "=" * (-len(value) % 4)).decode()
    except (binascii.Error, ValueError):
        return value


def _normalized(name: str) -> str:
    return unicodedata.normalize("NFC", name).casefold()


def _stem(name: str) -> str:
    return _VIDEO_SUFFIX.sub("", name)


def _upload_forms(stem: str, *norms: Literal["NFC", "NFD"]) -> set[str]:
    """A name and its form after an upload: spaces become ``_``; only letters, digits and ``-_.`` remain.

    Accents of a decomposed name (``NFD``, as macOS sends it) are no letters.
    """
    uploaded = (unicodedata.normalize(norm, stem).strip().replace(" ", "_") for norm in norms)
    return {_normalized(stem), *(_normalized(_REMOVED_CHARACTERS.sub("", text)) for text in uploaded)} - {""}
