"""Reads and writes class names by number in YOLO's files: ``obj.names`` (one a line) and ``data.yaml``."""

from __future__ import annotations

from pathlib import Path

from tsr_engine.exchange.label_files.label_collector import FileLabels, LabelCollector
from tsr_engine.exchange.reading import read_text, rule_error
from tsr_engine.exchange.yolo.class_names import MAX_YAML_BYTES, quoted_name, read_class_names
from tsr_engine.labels.model import LabelSet


def read_names(path: Path, key: str, name: str) -> FileLabels:
    """Read one name per line; the number is the line's index from 0.

    Raises:
        ImportFormatError: an empty line between names; names the line.
    """
    collector = LabelCollector(path.name)
    for number, line in enumerate(read_text(path, limit=MAX_YAML_BYTES).rstrip().splitlines()):
        if not line.strip():
            raise rule_error(path.name, number + 1, "is empty; every line must have a name. Add one.")
        collector.add(line, number + 1, number)
    return collector.finish(key, name)


def read_yaml_names(path: Path, key: str, name: str) -> FileLabels:
    """Read ``names`` of a ``data.yaml``: a list, or a map from number to name.

    Raises:
        ImportFormatError: not YAML, or no names; names the line.
    """
    collector = LabelCollector(path.name)
    found = read_class_names(path)
    if found is None:
        raise rule_error(path.name, None, "has no names. Write 'names: [stop, yield]'.")
    for number, each in sorted(found.items()):
        collector.add(each, f"names {number}", number)
    return collector.finish(key, name)


def write_names(labels: LabelSet) -> str:
    """The names alone, in the order of the set."""
    return "".join(f"{label.name}\n" for label in labels.offered())


def write_yaml_names(labels: LabelSet) -> str:
    """The names by index: YOLO needs 0, 1, 2 ... without gaps, so the indices are not ids."""
    return "names:\n" + "".join(
        f"  {index}: {quoted_name(label.name)}\n" for index, label in enumerate(labels.offered())
    )
