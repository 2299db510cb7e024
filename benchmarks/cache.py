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

    def get(self, made_from: Iterable[object], make: Callable[[], object]) -> Any:  # Any: a value of JSON
        """The stored record for some inputs, or a new one.

        Args:
            made_from: JSON values: all inputs of the record besides the code.
            make: makes the record, a JSON value.
        """
        if self._folder is None:
            return make()
        text = json.dumps([code(ENGINE), _own_code(), *made_from], sort_keys=True)
        path = self._folder / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.json"
        if path.is_file():
            return json.loads(path.read_text(encoding="utf-8"))
        record = json.loads(json.dumps(make()))  # gives the types of a stored record
        with atomic_text(path) as out:
            json.dump(record, out)
        return record


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
