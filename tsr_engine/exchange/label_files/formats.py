"""Lists, recognises, reads and writes the file formats of label sets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tsr_engine.errors import UsageError
from tsr_engine.exchange.label_files.class_names import read_names, read_yaml_names, write_names, write_yaml_names
from tsr_engine.exchange.label_files.coco_categories import read_categories, write_categories
from tsr_engine.exchange.label_files.collected import FileLabels
from tsr_engine.exchange.label_files.cvat_labels import read_cvat_labels, write_cvat_labels
from tsr_engine.exchange.label_files.label_config import read_label_config, write_label_config
from tsr_engine.exchange.reading import refuse
from tsr_engine.labels.files import dump_set, load_set
from tsr_engine.labels.model import LabelSet

__all__ = ["LABEL_FORMATS", "LabelFormat", "format_of", "read_labels", "write_labels"]

_HEAD: Final = 1 << 16


@dataclass(frozen=True, slots=True)
class LabelFormat:
    """One format.

    Attributes:
        id: its name in commands and addresses.
        file: usual name of such a file.
        media: media type.
        loses: what the format cannot hold, as a sentence; empty: nothing.
        read: path, key and name of the set -> labels.
        write: set -> text.
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
            "CVAT's labels have names, colours and attributes; aliases, shapes and pictures stay behind.",
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
            "COCO's categories hold ids, names and categories; the rest stays behind.",
            read_categories,
            write_categories,
        ),
        LabelFormat(
            "label-studio",
            "config.xml",
            "application/xml",
            "Label Studio holds one alias a label, and attributes of whole tracks; shapes and pictures stay behind.",
            read_label_config,
            write_label_config,
        ),
    )
}
"""Every format by its id."""


def format_of(path: Path, file: str = "") -> str:
    """The format of a file, by what is in it and what it is called.

    Args:
        path: the file.
        file: what it was called where it came from; empty: as ``path``.

    Raises:
        ImportFormatError: it cannot be read, or is of no such format.
    """
    file = (file or path.name).lower()
    try:
        with path.open("rb") as stream:
            head = stream.read(_HEAD).removeprefix(b"\xef\xbb\xbf").lstrip()
    except OSError as error:
        raise refuse(path.name, None, f"cannot be read: {error.strerror}.") from None
    if not head:
        raise refuse(path.name, None, "is empty.")
    if head.startswith(b"["):
        return "cvat"
    if head.startswith(b"{"):
        own = any(word in head for word in (b'"schema"', b'"next_id"'))
        return "tsr" if own or (b'"labels"' in head and b'"categories"' not in head) else "coco"
    if head.startswith(b"<"):
        return "label-studio"
    if file.endswith((".yaml", ".yml")) or any(line.startswith(b"names:") for line in head.splitlines()):
        return "yaml"
    if b"\0" in head:
        raise refuse(path.name, None, f"is no file of labels. Known are {', '.join(LABEL_FORMATS)}.")
    return "names"


def read_labels(path: Path, key: str, name: str, format: str | None = None) -> FileLabels:
    """The labels of a file.

    Args:
        path: the file.
        key: of the set that they become; our own files have a key.
        name: of that set; our own files have a name.
        format: see ``LABEL_FORMATS``; None: found out.

    Raises:
        UsageError: there is no such format.
        InputError: the file breaks a rule of its format; names it and where.
    """
    chosen = format_of(path) if format is None else format
    if chosen not in LABEL_FORMATS:
        raise UsageError(f"Expected a format of labels, one of {', '.join(LABEL_FORMATS)}. Got {chosen!r}.")
    return LABEL_FORMATS[chosen].read(path, key, name)


def write_labels(labels: LabelSet, format: str) -> str:
    """The text of a file.

    Raises:
        UsageError: there is no such format.
    """
    if format not in LABEL_FORMATS:
        raise UsageError(f"Expected a format of labels, one of {', '.join(LABEL_FORMATS)}. Got {format!r}.")
    return LABEL_FORMATS[format].write(labels)
