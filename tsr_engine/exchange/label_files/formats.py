"""Lists, recognises, reads and writes the file formats of label sets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tsr_engine.errors import UsageError
from tsr_engine.exchange.file_listing import head_of
from tsr_engine.exchange.label_files.class_names import read_names, read_yaml_names, write_names, write_yaml_names
from tsr_engine.exchange.label_files.coco_categories import read_categories, write_categories
from tsr_engine.exchange.label_files.cvat_labels import read_cvat_labels, write_cvat_labels
from tsr_engine.exchange.label_files.label_collector import FileLabels
from tsr_engine.exchange.label_files.label_config import read_label_config, write_label_config
from tsr_engine.exchange.reading import rule_error
from tsr_engine.labels.files import dump_set, load_set
from tsr_engine.labels.model import LabelSet


@dataclass(frozen=True, slots=True)
class LabelFormat:
    """A file format of label sets.

    Attributes:
        id: name of the format in commands and URLs.
        file: usual file name.
        media: media type.
        loses: one sentence on what the format cannot hold; empty: it holds everything.
        read: makes labels from a path and the key and name of the set.
        write: makes the text of a file.
    """

    id: str
    file: str
    media: str
    loses: str
    read: Callable[[Path, str, str], FileLabels]
    write: Callable[[LabelSet], str]


def _read_own(path: Path, key: str, name: str) -> FileLabels:
    return FileLabels(load_set(path))


LABEL_FORMATS: Final = {
    each.id: each
    for each in (
        LabelFormat("tsr", "labels.json", "application/json", "", _read_own, dump_set),
        LabelFormat(
            "cvat",
            "labels.json",
            "application/json",
            "CVAT's labels have names, colours and attributes; aliases, shapes and pictograms are lost.",
            read_cvat_labels,
            write_cvat_labels,
        ),
        LabelFormat(
            "names", "obj.names", "text/plain", "obj.names holds names and nothing else.", read_names, write_names
        ),
        LabelFormat(
            "yaml",
            "data.yaml",
            "application/yaml",
            "data.yaml holds names and nothing else.",
            read_yaml_names,
            write_yaml_names,
        ),
        LabelFormat(
            "coco",
            "categories.json",
            "application/json",
            "COCO's categories have ids, names and supercategories; all else is lost.",
            read_categories,
            write_categories,
        ),
        LabelFormat(
            "label-studio",
            "config.xml",
            "application/xml",
            "Label Studio has one alias per label, and attributes of whole tracks; shapes and pictograms are lost.",
            read_label_config,
            write_label_config,
        ),
    )
}
"""Every format by its id."""


def format_of(path: Path) -> str:
    """Recognise the format of a file by its content and name.

    Raises:
        ImportFormatError: the file cannot be read, or has no known format.
    """
    try:
        head = head_of(path, 1 << 16).removeprefix(b"\xef\xbb\xbf").lstrip()
    except OSError as error:
        raise rule_error(path.name, None, f"cannot be read: {error.strerror}.") from None
    if not head:
        raise rule_error(path.name, None, "is empty.")
    if head.startswith(b"["):
        return "cvat"
    if head.startswith(b"{"):
        is_own_format = any(word in head for word in (b'"schema"', b'"next_id"'))
        return "tsr" if is_own_format or (b'"labels"' in head and b'"categories"' not in head) else "coco"
    if head.startswith(b"<"):
        return "label-studio"
    if path.name.lower().endswith((".yaml", ".yml")) or any(line.startswith(b"names:") for line in head.splitlines()):
        return "yaml"
    if b"\0" in head:
        raise rule_error(path.name, None, f"is not a file of labels. Known formats are {', '.join(LABEL_FORMATS)}.")
    return "names"


def read_labels(path: Path, key: str, name: str, format: str | None = None) -> FileLabels:
    """Read the labels of a file.

    Args:
        path: the file.
        key: key of the new set; our own files have one already.
        name: name of the new set; our own files have one already.
        format: an id in ``LABEL_FORMATS``; None: recognise it.

    Raises:
        UsageError: the format is unknown.
        InputError: the file breaks a rule of its format; names the file and the place.
    """
    return _format_named(format_of(path) if format is None else format).read(path, key, name)


def write_labels(labels: LabelSet, format: str) -> str:
    """Return the text of a file.

    Raises:
        UsageError: the format is unknown.
    """
    return _format_named(format).write(labels)


def _format_named(name: str) -> LabelFormat:
    if name not in LABEL_FORMATS:
        raise UsageError(f"Expected a format of labels, one of {', '.join(LABEL_FORMATS)}. Got {name!r}.")
    return LABEL_FORMATS[name]
