"""Steps of a long comparison that are already done, kept so that it can go on where it was stopped.

A record is found by a digest of the code and of everything that it was made from, so what has changed is done anew.
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

__all__ = ["ENGINE", "Cache", "code", "digest_of", "file_digest"]

ENGINE = (
    "runs/calibration.py", "channels", "detection", "evaluation", "gating", "geometry", "io", "online", "params",
    "pipeline", "recognition", "tracking",
)  # fmt: skip
"""Parts of the engine that tracking depends on."""


class Cache:
    """Records in a folder; None: nothing is kept."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder

    def get(self, made_from: Iterable[object], make: Callable[[], object]) -> Any:
        """The record of what something was made from; made now where there is none.

        Args:
            made_from: values that JSON can hold; all that the record depends on besides the code.
            make: gives the record, a value that JSON can hold.
        """
        if self._folder is None:
            return make()
        text = json.dumps([code(ENGINE), _own(), *made_from], sort_keys=True)
        path = self._folder / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.json"
        if path.is_file():
            return json.loads(path.read_text(encoding="utf-8"))
        record = json.loads(json.dumps(make()))  # the same types as when it is read
        with atomic_text(path) as out:
            json.dump(record, out)
        return record


@cache
def code(steps: tuple[str, ...]) -> str:
    """Digest of parts of the engine as they are written; each a folder or a file below ``tsr_engine``."""
    root = Path(tsr_engine.__file__).parent
    return digest_of(root, [root / step for step in steps])


@cache
def file_digest(path: Path) -> str:
    """SHA-256 of a file's bytes."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


@cache
def _own() -> str:
    root = Path(__file__).parent
    return digest_of(root, [root])


def digest_of(root: Path, paths: list[Path]) -> str:
    """Digest of Python files, and of those in folders, as they are written; known by their place below ``root``."""
    digest = hashlib.sha256()
    for path in paths:
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(f"{file.relative_to(root)}\0".encode() + file.read_bytes())
    return digest.hexdigest()
