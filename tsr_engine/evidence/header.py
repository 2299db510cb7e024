"""Reads and writes ``run.json`` atomically: the inputs of a run and how it ended."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal, get_args

from tsr_engine.errors import EvidenceError
from tsr_engine.evidence.schema import RUN_FILE, SCHEMA_VERSION
from tsr_engine.io.atomic import atomic_text
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params.aliases import current_sections, stored_sections
from tsr_engine.version import __version__

RunState = Literal["running", "complete", "interrupted", "failed"]


@dataclass(frozen=True, slots=True)
class VideoIdentity:
    """Identity of a run's video: its content; the name is for people."""

    name: str
    """File name without folder."""
    sha256: str
    """SHA-256 of the file's bytes, hex."""
    size: int
    """Size in bytes."""


@dataclass(frozen=True, slots=True)
class RunHeader:
    """The inputs of a run.

    Attributes:
        video: the video file.
        parameters: all parameters, as from ``Params.model_dump()``; old names are converted on reading.
        models: component name -> sha256.
        frame_table: summary of the provisional frame table (time base as text, announced frames, size, rotation,
            ...), the learned lambda, and whether the focus was estimated from the drive; not part of the identity.
        engine_version: version of the engine.
        schema_version: version of the store's tables.
        created: UTC time in ISO 8601.
        state: ``running`` until the run is closed.
        reason: one sentence on why the run was interrupted or failed.
        keep_pixels: whether regions are stored; without them a run cannot be replayed.
        labels: keys of the classes by number; None: those of ``gtsrb-43``, as in older runs without keys.
    """

    video: VideoIdentity
    parameters: JsonMapping
    models: Mapping[str, str]
    frame_table: JsonMapping = field(default_factory=dict)
    engine_version: str = __version__
    schema_version: int = SCHEMA_VERSION
    created: str = field(default_factory=lambda: datetime.now(UTC).isoformat(timespec="seconds"))
    state: RunState = "running"
    reason: str = ""
    keep_pixels: bool = True
    labels: tuple[str, ...] | None = None

    def identity(self) -> str:
        """Digest of everything that decides the results: video content, parameters, models, engine, schema.

        Renamed parameters count under their first name, so a stored run keeps its digest.
        """
        content = {
            "video": [self.video.sha256, self.video.size],
            "parameters": stored_sections(self.parameters),
            "models": dict(self.models),
            "engine": self.engine_version,
            "schema": self.schema_version,
            "pixels": self.keep_pixels,
        } | ({} if self.labels is None else {"labels": list(self.labels)})
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    def ended(self, state: RunState, reason: str = "") -> RunHeader:
        """The header with another state."""
        return replace(self, state=state, reason=reason)

    def differences(self, other: RunHeader) -> list[str]:
        """Differences that make two runs unequal, each as "name: this against that"."""
        found = []
        if (self.video.sha256, self.video.size) != (other.video.sha256, other.video.size):
            found.append(f"video: {self.video.name} against {other.video.name}")
        for title, own_values, other_values in (
            ("parameter ", _flat(self.parameters), _flat(other.parameters)),
            ("model ", dict(self.models), dict(other.models)),
        ):
            for name in sorted(own_values.keys() | other_values.keys()):
                a, b = own_values.get(name, "unset"), other_values.get(name, "unset")
                if a != b:
                    found.append(f"{title}{name}: {str(a)[:12]} against {str(b)[:12]}")
        if self.labels != other.labels:
            found.append("labels: the classes of the two are not the same signs")
        for title, a, b in (
            ("engine version", self.engine_version, other.engine_version),
            ("schema version", self.schema_version, other.schema_version),
            ("pixels kept", self.keep_pixels, other.keep_pixels),
        ):
            if a != b:
                found.append(f"{title}: {a} against {b}")
        return found


def _flat(tree: JsonMapping, prefix: str = "") -> JsonObject:
    """A nested mapping as dotted names; values as JSON returns them."""
    flat: JsonObject = {}
    for key, value in tree.items():
        if isinstance(value, Mapping):
            flat |= _flat(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = json.loads(json.dumps(value))
    return flat


def write_header(folder: Path, header: RunHeader) -> None:
    """Write ``run.json`` atomically.

    Raises:
        StorageError: the folder cannot be written.
    """
    content = asdict(header) | {"identity": header.identity()}
    if header.labels is None:
        del content["labels"]
    with atomic_text(folder / RUN_FILE) as stream:
        stream.write(json.dumps(content, indent=1, sort_keys=True) + "\n")


def read_header(folder: Path) -> RunHeader:
    """Read and check ``run.json``.

    Raises:
        EvidenceError: missing, damaged, or of another schema version.
    """
    path = folder / RUN_FILE
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise EvidenceError(
            f"{folder} is no evidence folder: {RUN_FILE} is missing. Name the folder of a run."
        ) from None
    except (OSError, ValueError, RecursionError) as error:
        raise EvidenceError(f"{path} is damaged ({error}). Restore it or track the video again.") from None
    version = content.get("schema_version") if isinstance(content, dict) else None
    if type(version) is int and version != SCHEMA_VERSION:
        advice = "Update tsr" if version > SCHEMA_VERSION else "Track the video again"
        raise EvidenceError(
            f"{folder} has evidence schema {version}, this version reads schema {SCHEMA_VERSION}. {advice}."
        )
    try:
        header = _header_of(content)
        intact = header.identity() == content["identity"]
    except (KeyError, TypeError, ValueError, AttributeError):
        intact = False
    if not intact:
        raise EvidenceError(f"{path} is damaged: fields are missing or changed. Restore it or track the video again.")
    return header


def _header_of(content: JsonObject) -> RunHeader:
    video, state = content["video"], content["state"]
    if state not in get_args(RunState):
        raise ValueError(state)
    return RunHeader(
        video=VideoIdentity(str(video["name"]), str(video["sha256"]), int(video["size"])),
        parameters=current_sections(content["parameters"]),
        models=dict(content["models"]),
        frame_table=dict(content["frame_table"]),
        engine_version=str(content["engine_version"]),
        schema_version=int(content["schema_version"]),
        created=str(content["created"]),
        state=state,
        reason=str(content["reason"]),
        keep_pixels=bool(content["keep_pixels"]),
        labels=_labels_of(content.get("labels")),
    )


def _labels_of(keys: object) -> tuple[str, ...] | None:
    if keys is None:
        return None
    if not isinstance(keys, list) or not all(isinstance(key, str) for key in keys):
        raise ValueError(keys)
    return tuple(keys)
