"""Stores finished steps of a long comparison, so that it can continue after a stop.

The key of a record is a digest of the code and of all inputs, so that changed steps are done again.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any

import tsr_engine
from tsr_engine.io.atomic import atomic_text
from tsr_engine.track_table import TrackTable

ENGINE = (
    "runs/calibration.py", "channels", "detection", "evaluation", "gating", "geometry", "io", "online", "params",
    "pipeline", "recognition", "tracking",
)  # fmt: skip
"""Parts of the engine that tracking depends on."""


class Cache:
    """Records in a folder; None: nothing is stored."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder

    def get(self, inputs: Iterable[object], compute: Callable[[], object]) -> Any:  # Any: a value of JSON
        """The stored record for some inputs, or a new one.

        Args:
            inputs: JSON values: all inputs of the record besides the code.
            compute: computes the record, a JSON value.
        """
        inputs = list(inputs)
        record = self.find(inputs)
        if record is None:
            record = json.loads(json.dumps(compute()))  # gives the types of a stored record
            self.keep(inputs, record)
        return record

    def find(self, inputs: Iterable[object]) -> Any:  # Any: a value of JSON
        """The stored record for some inputs; None: there is none."""
        path = self._path(inputs)
        return json.loads(path.read_text(encoding="utf-8")) if path is not None and path.is_file() else None

    def keep(self, inputs: Iterable[object], record: object) -> None:
        """Store the record for some inputs."""
        path = self._path(inputs)
        if path is not None:
            with atomic_text(path) as out:
                json.dump(record, out)

    def _path(self, inputs: Iterable[object]) -> Path | None:
        return None if self._folder is None else self._folder / f"{cache_key(inputs)}.json"


def cache_key(inputs: Iterable[object]) -> str:
    """Digest of the code and of JSON values, for the name of a file."""
    text = json.dumps([code(ENGINE), _own_code(), *inputs], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@cache
def code(steps: tuple[str, ...]) -> str:
    """Digest of the source of parts of the engine, each a folder or a file below ``tsr_engine``."""
    root = Path(tsr_engine.__file__).parent
    return digest_of(root, [root / step for step in steps])


@cache
def file_digest(path: Path) -> str:
    """SHA-256 of a file's bytes."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def table_digest(table: TrackTable) -> str:
    """SHA-256 of a table of annotated boxes."""
    digest = hashlib.sha256()
    for column in (table.frame, table.track, table.boxes, table.class_id, table.ignore, table.visibility):
        digest.update(column.tobytes())
    return digest.hexdigest()


@cache
def _own_code() -> str:
    root = Path(__file__).parent
    return digest_of(root, [root / "peers", root / "videos", root / "corruptions" / "detections.py"])


def digest_of(root: Path, paths: list[Path]) -> str:
    """Digest of the source of Python files, and of those in folders, with their paths relative to ``root``."""
    digest = hashlib.sha256()
    for path in paths:
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(f"{file.relative_to(root)}\0".encode() + file.read_bytes())
    return digest.hexdigest()
