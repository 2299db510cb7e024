"""Reads and writes label sets as files: our JSON, and the sets that ship with the package."""

from __future__ import annotations

import codecs
import json
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from tsr_engine.errors import InputError
from tsr_engine.io.atomic import atomic_text
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.model import MAX_LABELS, SCHEMA, LabelSet
from tsr_engine.labels.name_matching import first_problem

DEFAULT: Final = "gtsrb-43"
"""Key of the set of a new library."""
VIENNA: Final = "vienna"
"""Key of the set of all signs of the Vienna Convention."""
_MAX_BYTES: Final = 64 << 20
_SETS = resources.files("tsr_engine.labels") / "sets"
SHIPPED: Final = tuple(
    sorted(place.name.removesuffix(".json") for place in _SETS.iterdir() if place.name.endswith(".json"))
)
"""Keys of the sets that ship with the package."""


@cache
def shipped_set(key: str) -> LabelSet:
    """Load a set that ships with the package.

    Raises:
        KeyError: no shipped set has that key.
    """
    if key not in SHIPPED:
        raise KeyError(key)
    return parse_set((_SETS / f"{key}.json").read_bytes(), key).model_copy(update={"version": 1})


def parse_set(text: str | bytes, where: str) -> LabelSet:
    """Parse a label set from our JSON.

    Args:
        text: content of the file.
        where: the file's name, for messages.

    Raises:
        InputError: it is not a label set; names the first broken rule and its place.
    """
    if isinstance(text, bytes):
        text = text.removeprefix(codecs.BOM_UTF8)
    try:
        content = json.loads(text, object_pairs_hook=_unique_keys)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where} is not a label set: it is not JSON ({error}).") from None
    version = content.get("schema") if isinstance(content, dict) else None
    if isinstance(version, int) and version > SCHEMA:
        raise InputError(
            f"{where} is written in schema {version}; this version of tsr reads up to {SCHEMA}. Update tsr."
        )
    rows = content.get("labels") if isinstance(content, dict) else None
    if isinstance(rows, list) and len(rows) > MAX_LABELS:
        raise InputError(f"{where} has {len(rows)} labels; a set has at most {MAX_LABELS}.")
    try:
        return LabelSet.model_validate_json(text)
    except ValidationError as error:
        place, problem = first_problem(error)
        raise InputError(f"{where} is not a label set: {place or 'the set'}: {problem}.") from None


def _unique_keys(pairs: list[tuple[str, object]]) -> JsonObject:
    """Build a JSON object; a repeated key is refused, because one of its values would be lost."""
    found = dict(pairs)
    if len(found) != len(pairs):
        names = [name for name, _ in pairs]
        raise ValueError(f"an object has {next(name for name in names if names.count(name) > 1)[:60]!r} twice")
    return found


def load_set(path: Path) -> LabelSet:
    """Load a label set from a file in our format.

    Raises:
        InputError: it cannot be read, or is not a label set.
    """
    try:
        if path.stat().st_size > _MAX_BYTES:
            raise InputError(f"{path} is larger than the {_MAX_BYTES} bytes of the largest label set.")
        return parse_set(path.read_bytes(), path.name)
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}.") from None


def dump_set(labels: LabelSet) -> str:
    """A set as our JSON, one label per line; equal sets give equal text."""
    content = labels.model_dump(mode="json", by_alias=True, exclude_defaults=True)
    rows = content.pop("labels", [])
    head = {
        "schema": labels.schema_version,
        "key": labels.key,
        "name": labels.name,
        "version": labels.version,
        "next_id": labels.next_id,
    }
    lines = ",\n".join("    " + json.dumps(row, ensure_ascii=False) for row in rows)
    opening = json.dumps(head, ensure_ascii=False, indent=2).removesuffix("\n}")
    return f'{opening},\n  "labels": [\n{lines}\n  ]\n}}\n' if rows else f'{opening},\n  "labels": []\n}}\n'


def save_set(labels: LabelSet, path: Path) -> None:
    """Write a set as our JSON, atomically.

    Raises:
        StorageError: the file cannot be written.
    """
    with atomic_text(path) as file:
        file.write(dump_set(labels))
