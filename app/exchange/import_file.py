"""Reads a file of another tool for a video, with the labels of the video's set."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from app.errors import Invalid
from app.exchange.dataset import LABELS, VideoInfo
from tsr_engine.bundle.layout import FRAMES, OUTPUT
from tsr_engine.bundle.layout import MANIFEST as BUNDLE_MANIFEST
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.added_labels import UnknownLabels
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.file_listing import head_of
from tsr_engine.exchange.formats import Format, ImportLimits, ImportTarget, UnknownNames
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import complete_switches, format_named
from tsr_engine.exchange.untrusted_zip import entry_names, is_archive
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.labels.model import LabelSet

HTTP_REMEDY = (
    "Map them to labels (label_map), add them to the set (unknown=add, or some of them with add), or leave "
    "their tracks out (unknown=skip)."
)
_MAX_NAMES = 2000
"""Maximum number of names in the refusal of unknown names."""


@dataclass(frozen=True, slots=True)
class ImportFile:
    """A file, and a person's options for its import.

    Attributes:
        path: file, archive or folder.
        name: name of the ground truth or run; a ground truth replaces one of the same name.
        format: name of its format; None: detected.
        switches: options of the format.
        label_map: name in the file -> number or key of a label, -1: no label of the set.
        unknown: treatment of other names that no label has; see ``ImportTarget``.
        added: names to add to the set whatever ``unknown`` is.
        remedy: how to map unknown names, for the refusal of a file.
        author: author of the import.
        scratch: folder for unpacked archives; None: the system's.
    """

    path: Path
    name: str
    format: str | None = None
    switches: Mapping[str, str] = field(default_factory=dict)
    label_map: Mapping[str, int | str] = field(default_factory=dict)
    unknown: UnknownNames = "refuse"
    added: frozenset[str] = frozenset()
    remedy: str = HTTP_REMEDY
    author: str = ""
    scratch: Path | None = None


@dataclass(frozen=True, slots=True)
class VideoTarget:
    """The target of an import: the video, its labels, remembered mappings of names, and limits."""

    video: VideoInfo
    table: FrameTable
    size: int
    limits: ImportLimits
    labels: LabelSet = LABELS
    remembered: Mapping[str, int] = field(default_factory=dict)


def read_import_file(file: ImportFile, target: VideoTarget, progress: Callable[[int], None] | None = None) -> Dataset:
    """Read a file for a video.

    Args:
        file: the file.
        target: the target.
        progress: called now and then with the number of boxes read.

    Raises:
        Invalid: the file has no boxes, an option is invalid, or no label has some names (code ``unknown_labels``;
            ``details`` lists them).
        UsageError: an unknown format, option or class.
        ImportFormatError: the file breaks a rule; the message names file, line and rule.
    """
    _refuse_non_annotations(file.path)
    try:
        with_progress = replace(reader_target(file, target), progress=progress)
        dataset = read_dataset(file.path, with_progress, _requested_format(file), scratch=file.scratch)
    except UnknownLabels as error:
        raise _unknown_labels(error, file.remedy) from None
    if next(iter(dataset.videos[0].tracks()), None) is None:
        raise Invalid(f"{file.path.name} holds no boxes for {target.video.name}. Check the file.", code="nothing")
    return dataset


def reader_target(file: ImportFile, target: VideoTarget) -> ImportTarget:
    """Build the reader's target of an import.

    Raises:
        Invalid, UsageError: as for ``read_import_file``.
    """
    chosen = _requested_format(file)
    options = dict(file.switches)
    # if the format is detected, the reader checks them
    switches = options if chosen is None else complete_switches(chosen, options, reading=True)
    return ImportTarget(
        target.video.without_tracks(),
        target.labels,
        switches,
        dict(file.label_map),
        remembered=target.remembered,
        unknown=file.unknown,
        added=file.added,
        limits=target.limits,
    )


def _unknown_labels(error: UnknownLabels, remedy: str) -> Invalid:
    """The refusal that lists the names without a label, so that a page can ask for them."""
    names = [
        {
            "name": unknown.name,
            "tracks": unknown.tracks,
            "boxes": unknown.boxes,
            "suggestions": [{"id": label.id, "key": label.key, "name": label.name} for label in unknown.suggestions],
            "similar": unknown.similar,
            "example": {"frame": unknown.frame, "box": list(unknown.box)},
        }
        for unknown in error.labels[:_MAX_NAMES]
    ]
    details = {"labels": names, "count": len(error.labels)}
    return Invalid(f"{error} {remedy}", code="unknown_labels", field="label_map", details=details)


def _requested_format(file: ImportFile) -> Format | None:
    chosen = None if file.format is None else format_named(file.format)
    if chosen is not None and chosen.read is None:
        raise Invalid(f"{chosen.title} can be exported, not imported. Choose another format.", field="format")
    return chosen


def _refuse_non_annotations(path: Path) -> None:
    """Refuse files that would otherwise be reported as an unknown format: a truncated archive, and a bug bundle.

    Raises:
        ImportFormatError: the file is one of these, or an archive that is damaged or over the limits.
    """
    if not path.is_file():
        return
    if is_archive(path):
        if {BUNDLE_MANIFEST, FRAMES, OUTPUT} <= set(entry_names(path)):
            raise ImportFormatError(
                f"{path.name}: is a bug bundle, not annotations. Replay it with 'tsr replay {path.name}', or open it "
                "with 'Open bug bundle' in the library."
            )
        return
    if head_of(path, 4) == b"PK\x03\x04":
        raise ImportFormatError(f"{path.name}: is a ZIP archive whose end is missing. Copy or download it again.")
