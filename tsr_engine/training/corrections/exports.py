"""Opens exports of this tool as training data: tracks by the format's reader, pictures from the video or the export.

The video, identified by its SHA-256, is preferred: it has every frame, so frames without signs can be drawn as
background. Without the video, the pictures in the export are used.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Final

import numpy as np

from tsr_engine.errors import ImportFormatError, InputError
from tsr_engine.exchange.archive import unpack
from tsr_engine.exchange.dataset import REJECTED, Dataset, DatasetVideo, Track
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.manifest import MANIFEST, labels_of, read_manifest
from tsr_engine.exchange.registry import format_named
from tsr_engine.exchange.untrusted_zip import is_archive
from tsr_engine.io.digest import file_sha256
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.track_table import NO_CLASS
from tsr_engine.training.corrections.corrected_scenes import verdict

__all__ = ["OpenedExport", "open_export"]

_REVIEWED: Final = frozenset({"accepted", "rejected"})
_BOXES: Final = re.compile(r"\d (track|tracks|box|boxes)\b| to ignore$")
"""Tracks, boxes or regions to ignore, among what an export counts as skipped."""


@dataclass(frozen=True, slots=True)
class OpenedExport:
    """An export as training data.

    Attributes:
        dataset: its videos and tracks, with the labels of its own set.
        pictures: per video, frame -> picture of the export; empty if the video itself is available.
        split: subset of each (video, sign) in the export's split; empty: no split.
        about: for the lineage: name, SHA-256, format, runs and edit revisions.
        notes: what was left out and why, one sentence each.
    """

    dataset: Dataset
    pictures: tuple[Mapping[int, Path], ...]
    split: Mapping[tuple[str, str], str]
    about: JsonMapping
    notes: tuple[str, ...] = field(default=())


def open_export(
    path: Path,
    find: Callable[[str, str], VideoSource | None],
    scratch: Path,
    limits: VideoLimits | None = None,
    name: str = "",
) -> OpenedExport:
    """Open an export folder or ZIP file.

    Args:
        path: output of ``tsr export`` or of the page.
        find: returns the file of a video by its SHA-256 and name; None: not available.
        scratch: an existing folder in which archives are unpacked and kept.
        limits: limits on the videos; unset: ``VideoLimits()``.
        name: its name for people; empty: that of the file or folder.

    Raises:
        InputError: the path does not exist.
        ImportFormatError: not an export of this tool, damaged, or of a format that cannot be imported.
    """
    if not path.exists():
        raise InputError(f"There is no export at {path}. Check the path.")
    folder = path
    if path.is_file():
        if not is_archive(path):
            raise ImportFormatError(f"{path}: expected an export folder or a ZIP file of one. Name one of these.")
        folder = Path(tempfile.mkdtemp(prefix="export-", dir=scratch))
        unpack(path, folder)
    try:
        content = read_manifest(folder).content
    except ImportFormatError:
        if folder is path:
            raise
        # The folder is temporary, so the message must not name it.
        raise ImportFormatError(
            f"{path}: is not an export of this tool but another archive, perhaps a bug bundle. Name one that 'tsr "
            "export' made."
        ) from None
    chosen = format_named(str(content["format"]["name"]))
    if chosen.read is None:
        raise ImportFormatError(
            f"{path}: {chosen.title} cannot be imported, so its boxes are lost. Export in another format, or name a "
            "folder of crops with --gtsrb."
        )
    labels = labels_of(content)
    name = name or path.name
    videos: list[DatasetVideo] = []
    pictures: list[Mapping[int, Path]] = []
    notes: list[str] = []
    for entry in content["videos"]:
        bare = _bare(entry, find(str(entry["sha256"]), str(entry["name"])), limits)
        own = {} if bare.path is not None else _pictures(folder, entry)
        if bare.path is None and not own:
            notes.append(f"{name}: the file of {bare.name} is missing and the export has no pictures of it.")
            continue
        read = read_dataset(folder, ImportTarget(bare, labels), chosen).videos[0]
        tracks = tuple(_reviewed(read.tracks(), content))
        if tracks and all(verdict(track) == "unknown" for track in tracks):
            notes.append(
                f"{name} has no track that is marked as accepted. Export only accepted tracks, or in a format "
                "that has review states, such as cvat-video or tracks-json."
            )
        tracks += tuple(_left_out(entry, name))
        if "left_out" not in entry and _leaves_out(content):
            notes.append(
                f"{name}: an earlier version of tsr made it without the places of what it leaves out, so unjudged "
                "signs there may be learned as background; export again."
            )
        videos.append(replace(bare, tracks=lambda tracks=tracks: iter(tracks)))  # type: ignore[misc]
        pictures.append(own)
    about = {
        "name": name,
        "sha256": file_sha256(path if path.is_file() else path / MANIFEST),
        "format": chosen.name,
        "runs": [dict(entry.get("provenance", {})) for entry in content["videos"]],
        "videos": [entry["sha256"] for entry in content["videos"]],
        "names": [entry["name"] for entry in content["videos"]],
    }
    split = {(str(v), str(uid)): str(side) for v, uid, side in content.get("split", {}).get("tracks", [])}
    return OpenedExport(Dataset(labels, tuple(videos)), tuple(pictures), split, about, tuple(dict.fromkeys(notes)))


def _bare(entry: JsonMapping, path: VideoSource | None, limits: VideoLimits | None) -> DatasetVideo:
    rate = entry.get("rate")
    return DatasetVideo(
        name=str(entry["name"]),
        sha256=str(entry["sha256"]),
        width=int(entry["width"]),
        height=int(entry["height"]),
        frames=int(entry["frames"]),
        rate=None if rate is None else Fraction(str(rate)),
        times=None,
        constant_rate=bool(entry.get("constant_rate", True)),
        tracks=lambda: iter(()),
        path=path,
        first=int(entry.get("first", 0)),
        stop=int(entry.get("stop", 0)),
        provenance=dict(entry.get("provenance", {})),
        limits=limits,
    )


def _pictures(folder: Path, entry: JsonMapping) -> dict[int, Path]:
    """Pictures of a video in the export, by frame."""
    table = entry.get("frame_table", {})
    root = folder.resolve()
    found: dict[int, Path] = {}
    for frame, name in zip(table.get("frame", ()), table.get("file", ()), strict=False):
        if name is None:
            continue
        place = (root / str(name)).resolve()
        if place.is_relative_to(root) and place.is_file():
            found[int(frame)] = place
    return found


def _left_out(entry: JsonMapping, name: str) -> Iterator[Track]:
    """Boxes of the run that the export leaves out, as open tracks: their places are neither signs nor background."""
    for number, one in enumerate(entry.get("left_out", ())):
        try:
            frames, boxes = np.array(one["frames"], np.int64), np.array(one["boxes"], np.float64)
            blank = np.zeros(len(frames), np.bool_)
            if boxes.shape != (len(frames), 4):
                raise ValueError
        except (KeyError, TypeError, ValueError, OverflowError):
            raise ImportFormatError(
                f"{name}: {MANIFEST} must list frames and as many boxes for all that is left out. Export again."
            ) from None
        yield Track(f"left-out-{number}", NO_CLASS, frames, boxes, blank, blank, np.full(len(frames), np.nan))


def _leaves_out(content: JsonMapping) -> bool:
    """Whether an export lacks boxes that its runs have within the exported frames, by the sentences of its manifest."""
    return content.get("asked", {}).get("tracks") is not None or any(
        _BOXES.search(item["what"]) and not item["reason"].startswith("They lie outside ")
        for item in content.get("skipped", ())
    )


def _reviewed(tracks: Iterator[Track], content: JsonMapping) -> Iterator[Track]:
    """Yield tracks with their review states.

    Formats without review states give open tracks. If the export was limited to accepted tracks, they are accepted.
    """
    asked = content.get("asked", {}).get("states")
    # Exports that separate rejected tracks have none among the others, whatever state the reader gave these.
    if "negatives" in content.get("counts", {}) and isinstance(asked, list) and len(asked) > 1:
        asked = [state for state in asked if state != REJECTED]
    only = str(asked[0]) if isinstance(asked, Sequence) and len(asked) == 1 and asked[0] in _REVIEWED else None
    for track in tracks:
        yield replace(track, state=only) if only is not None and track.state == "open" else track
