"""Stores the progress of a batch in one JSON file of its folder, replaced atomically after each change."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Final, Literal

from pydantic import TypeAdapter, ValidationError

from tsr_engine.errors import StorageError, UsageError
from tsr_engine.io.atomic import atomic_text
from tsr_engine.json_shapes import JsonObject

MANIFEST: Final = "batch.json"
_VERSION: Final = 1
State = Literal["waiting", "done", "failed"]


@dataclass(frozen=True)
class Identity:
    """Inputs that decide the results of every drive.

    Attributes:
        version: version of tsr.
        parameters: all parameters as JSON.
        models: component -> SHA-256.
    """

    version: str
    parameters: JsonObject
    models: dict[str, str]

    def differences(self, other: Identity) -> list[str]:
        """The differences in words; empty: equal."""
        found = [] if self.version == other.version else [f"version {self.version}, not {other.version}"]
        for section, values in self.parameters.items():
            other_values = other.parameters.get(section)
            if not isinstance(values, Mapping) or not isinstance(other_values, Mapping):
                found += [] if values == other_values else [section]
                continue
            found += [
                f"{name}={v}, not {other_values.get(name)}" for name, v in values.items() if v != other_values.get(name)
            ]
        names = dict.fromkeys((*self.models, *other.models))
        return found + [f"another {name}" for name in names if self.models.get(name) != other.models.get(name)]


@dataclass
class DriveState:
    """A drive and its state.

    Attributes:
        video: absolute path.
        folder: name of its folder of results.
        size, changed: size in bytes and modification time in ns since 1970 of the file when it was tracked.
        stamp: stamp of its last task, whether or not that finished; empty in older manifests.
        state: ``waiting`` also while the drive is tracked.
        error: one sentence on why it failed.
        result: figures of a finished drive: ``frames``, ``seconds``, ``tracks`` ...
    """

    video: str
    folder: str
    size: int = 0
    changed: int = 0
    stamp: str = ""
    state: State = "waiting"
    error: str = ""
    result: JsonObject = field(default_factory=dict)


@dataclass
class Manifest:
    """Content of ``batch.json``: what decides the results, and every drive of the batch."""

    identity: Identity
    drives: list[DriveState]
    schema: int = _VERSION


_ADAPTER: TypeAdapter[Manifest] = TypeAdapter(Manifest)


def load_manifest(out: Path) -> Manifest | None:
    """Read the manifest of a folder; None: there is none.

    Raises:
        StorageError: it cannot be read.
        UsageError: it is damaged, or from a newer version.
    """
    path = out / MANIFEST
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return None
    except OSError as error:
        raise StorageError(f"{path} cannot be read: {error.strerror}.") from None
    try:
        content = json.loads(text)
        if isinstance(content, dict) and isinstance(content.get("schema"), int) and content["schema"] > _VERSION:
            raise UsageError(f"{path} was written by a newer version of tsr. Update tsr, or use another --out.")
        return _ADAPTER.validate_python(content)
    except (ValueError, ValidationError):
        raise UsageError(f"{path} is damaged. Move it away to track all drives anew, or use another --out.") from None


def save_manifest(manifest: Manifest, out: Path) -> None:
    """Replace the manifest of a folder.

    Raises:
        StorageError: it cannot be written.
    """
    with atomic_text(out / MANIFEST) as file:
        json.dump(asdict(manifest), file, indent=1)  # ASCII: a file's name may be no UTF-8
