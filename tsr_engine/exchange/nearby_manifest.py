"""Reads from a manifest beside or above a file what the file's reader needs.

Only this part is kept, because a manifest lists every frame and every file of its export.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.dataset import DatasetVideo
from tsr_engine.exchange.file_listing import is_system_file
from tsr_engine.exchange.json_stream import members
from tsr_engine.exchange.manifest import MANIFEST, VERSION
from tsr_engine.exchange.video_names import is_name_of, video_names
from tsr_engine.json_shapes import JsonMapping

_EXPORT_SUBFOLDERS = frozenset({"annotations", "Annotations", "gt", "det", "train", "val", "test"})


@dataclass(frozen=True, slots=True, eq=False)
class ManifestSummary:
    """The part of a manifest that readers need.

    Attributes:
        format: the manifest's section on the format.
        videos: its videos without frame tables and left-out boxes.
    """

    format: JsonMapping
    videos: tuple[JsonMapping, ...]

    def entry(self, video: DatasetVideo) -> JsonMapping | None:
        """The entry of a video: by hash, else the only one with its name; None: there is none."""
        for candidates in (
            [entry for entry in self.videos if video.sha256 and entry.get("sha256") == video.sha256],
            [entry for entry in self.videos if entry.get("name") == video.name],
        ):
            if len(candidates) == 1:
                return candidates[0]
        return None

    def name_of(self, video: DatasetVideo) -> str:
        """The video's name within the export; empty: the export has no such video."""
        entry = self.entry(video)
        if entry is None:
            return ""
        if "called" in entry:
            return str(entry["called"])
        # Older exports do not store the names.
        return video_names([_video_of_entry(other) for other in self.videos])[self.videos.index(entry)]


def find_manifest(folder: Path) -> ManifestSummary | None:
    """The manifest of the export that contains a folder; None: there is none, or another tool wrote it."""
    current = folder
    while not (current / MANIFEST).is_file():
        # Go up only from folders inside an export, not into its surroundings.
        if current.name not in _EXPORT_SUBFOLDERS:
            return None
        current = current.parent
    path = current / MANIFEST
    status = path.stat()
    return _read(path, status.st_mtime_ns, status.st_size)


def manifest_value(folder: Path, key: str) -> str:
    """The entry ``key`` of the format section in our manifest beside a file; empty: there is none."""
    manifest = find_manifest(folder)
    return "" if manifest is None else str(manifest.format.get(key, ""))


def prefix_in_export(folder: Path, video: DatasetVideo) -> str:
    """The prefix of the names of the video's pictures, if a manifest lists several videos; else empty."""
    manifest = find_manifest(folder)
    name = manifest.name_of(video) if manifest is not None and len(manifest.videos) > 1 else ""
    return f"{name}_" if name else ""


def is_named_after(folder: Path, video: DatasetVideo, name: str) -> bool:
    """Whether a file or folder is named after a video: by the name in our manifest, else by the video's own name."""
    manifest = find_manifest(folder)
    exported_name = manifest.name_of(video) if manifest is not None else ""
    return name.casefold() == exported_name.casefold() if exported_name else is_name_of(name, video)


def visible_entries(path: Path) -> list[Path]:
    """Entries of a folder without hidden files and system files; empty for a file."""
    if not path.is_dir():
        return []
    return [entry for entry in path.iterdir() if not entry.name.startswith(".") and not is_system_file(entry.name)]


def is_wrapper(path: Path) -> bool:
    """Whether a folder holds only one folder, as in many archives; the import then begins in the inner folder."""
    inside = visible_entries(path)
    return len(inside) == 1 and inside[0].is_dir() and inside[0].name not in ("train", "val", "valid", "test")


@lru_cache(maxsize=8)
def _read(path: Path, _changed: int, _size: int) -> ManifestSummary | None:
    format_section: JsonMapping = {}
    videos: list[JsonMapping] = []
    version: object = None
    try:
        for key, _, value in members(path):
            if key == "manifest":
                version = value
            elif key == "format" and isinstance(value, dict):
                format_section = value
            elif key == "videos" and isinstance(value, dict):
                for name in ("frame_table", "left_out"):
                    value.pop(name, None)
                videos.append(value)
    except ImportFormatError:
        return None
    return ManifestSummary(format_section, tuple(videos)) if version == VERSION else None


def _video_of_entry(entry: JsonMapping) -> DatasetVideo:
    name, digest = str(entry.get("name", "")), str(entry.get("sha256", ""))
    return DatasetVideo(name, digest, 1, 1, 1, None, None, True, lambda: iter(()))
