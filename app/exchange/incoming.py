"""Reads a file of another tool for a video, with the labels of the video's set."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from app.errors import Invalid
from app.exchange.dataset import LABELS, VideoFacts
from tsr_engine.bundle.layout import FRAMES, OUTPUT
from tsr_engine.bundle.layout import MANIFEST as BUNDLE_MANIFEST
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.added_labels import UnknownLabels
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.formats import Format, ImportLimits, ImportTarget, UnknownNames
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import complete_switches, format_named
from tsr_engine.exchange.untrusted_zip import entry_names, is_archive
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.labels.model import LabelSet

__all__ = ["Incoming", "Onto", "read_incoming", "target_of"]

HTTP_WAYS = (
    "Map them to labels (label_map), add them to the set (unknown=add, or some of them with add), or leave "
    "their tracks out (unknown=skip)."
)
_MOST_NAMES = 2000
"""Maximum number of names in the refusal of unknown names."""


@dataclass(frozen=True, slots=True)
class Incoming:
    """A file, and a person's options for its import.

    Attributes:
        path: file, archive or folder.
        name: name of the ground truth or run; a ground truth replaces one of the same name.
        format: name of its format; None: detected.
        switches: options of the format.
        label_map: name in the file -> number or key of a label, -1: no label of the set.
        unknown: treatment of other names that no label has; see ``ImportTarget``.
        added: names to add to the set whatever ``unknown`` is.
        ways: how to map unknown names, for the refusal of a file.
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
    ways: str = HTTP_WAYS
    author: str = ""
    scratch: Path | None = None


@dataclass(frozen=True, slots=True)
class Onto:
    """The target of an import: the video, its labels, remembered mappings of names, and limits."""

    facts: VideoFacts
    table: FrameTable
    size: int
    limits: ImportLimits
    labels: LabelSet = LABELS
    words: Mapping[str, int] = field(default_factory=dict)


def read_incoming(incoming: Incoming, onto: Onto, progress: Callable[[int], None] | None = None) -> Dataset:
    """Read a file for a video.

    Args:
        incoming: the file.
        onto: the target.
        progress: called now and then with the number of boxes read.

    Raises:
        Invalid: the file has no boxes, an option is invalid, or no label has some names (code ``unknown_labels``;
            ``details`` lists them).
        UsageError: an unknown format, option or class.
        ImportFormatError: the file breaks a rule; the message names file, line and rule.
    """
    _no_annotations(incoming.path)
    try:
        target = replace(target_of(incoming, onto), progress=progress)
        dataset = read_dataset(incoming.path, target, _chosen(incoming), scratch=incoming.scratch)
    except UnknownLabels as error:
        raise _unknown(error, incoming.ways) from None
    if next(iter(dataset.videos[0].tracks()), None) is None:
        raise Invalid(f"{incoming.path.name} holds no boxes for {onto.facts.name}. Check the file.", code="nothing")
    return dataset


def target_of(incoming: Incoming, onto: Onto) -> ImportTarget:
    """Build the reader's target of an import.

    Raises:
        Invalid, UsageError: as for ``read_incoming``.
    """
    chosen = _chosen(incoming)
    asked = dict(incoming.switches)
    # if the format is detected, the reader checks them
    switches = asked if chosen is None else complete_switches(chosen, asked, reading=True)
    return ImportTarget(
        onto.facts.without_tracks(),
        onto.labels,
        switches,
        dict(incoming.label_map),
        remembered=onto.words,
        unknown=incoming.unknown,
        added=incoming.added,
        limits=onto.limits,
    )


def _unknown(error: UnknownLabels, ways: str) -> Invalid:
    """The refusal that lists the names without a label, so that a page can ask for them."""
    names = [
        {
            "name": each.name,
            "tracks": each.tracks,
            "boxes": each.boxes,
            "suggestions": [{"id": label.id, "key": label.key, "name": label.name} for label in each.suggestions],
            "similar": each.similar,
            "example": {"frame": each.frame, "box": list(each.box)},
        }
        for each in error.labels[:_MOST_NAMES]
    ]
    details = {"labels": names, "count": len(error.labels)}
    return Invalid(f"{error} {ways}", code="unknown_labels", field="label_map", details=details)


def _chosen(incoming: Incoming) -> Format | None:
    chosen = None if incoming.format is None else format_named(incoming.format)
    if chosen is not None and chosen.read is None:
        raise Invalid(f"{chosen.title} can be exported, not imported. Choose another format.", field="format")
    return chosen


def _no_annotations(path: Path) -> None:
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
    with path.open("rb") as file:
        begins = file.read(4)
    if begins == b"PK\x03\x04":
        raise ImportFormatError(f"{path.name}: is a ZIP archive whose end is missing. Copy or download it again.")
