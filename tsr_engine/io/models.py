"""Models on disk: one NumPy archive a component and a manifest that names and hashes them. Never pickle.

::

    MODELS/
      manifest.json     {"format": 2, "components": {"detector": {...}, "prior": {...}, ...}}
      detector.npz      plain arrays
      ...

A component of the manifest holds ``file``, ``sha256``, ``params`` (what inference needs besides the arrays),
``data`` (what it was trained on), ``figures`` (held-out results) and ``seed``.
"""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import ModelError, StorageError
from tsr_engine.version import __version__

FORMAT = 2
MANIFEST = "manifest.json"
SHIPPED = Path(__file__).resolve().parent.parent / "models"


@dataclass(frozen=True, slots=True)
class Component:
    """One trained part: arrays, the parameters that inference needs, and where it comes from."""

    name: str
    arrays: Mapping[str, NDArray[Any]]
    params: Mapping[str, Any] = field(default_factory=dict)
    data: Mapping[str, Any] = field(default_factory=dict)
    figures: Mapping[str, Any] = field(default_factory=dict)
    seed: int | None = None
    sha256: str = ""


def load_component(name: str, folder: Path | None = None) -> Component:
    """Read and verify one component.

    Args:
        name: ``detector``, ``prior``, ``classifier``, ``online``, ...
        folder: a model folder; unset: the models shipped with the package.

    Raises:
        ModelError: no manifest, another format, missing component, wrong hash, or unreadable arrays.
    """
    folder = SHIPPED if folder is None else folder
    entry = read_manifest(folder)["components"].get(name)
    if entry is None:
        raise ModelError(f"The models in {folder} have no component '{name}'. Train one with `tsr train`.")
    path = folder / str(entry["file"])
    if path.parent != folder:
        raise ModelError(f"Component '{name}' in {folder} names a file outside the folder: {entry['file']}.")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ModelError(
            f"Cannot read the model file {path}: {error.strerror}. Restore the file or train it again."
        ) from None
    digest = hashlib.sha256(content).hexdigest()
    if digest != entry["sha256"]:
        raise ModelError(
            f"{path} does not match its manifest: expected sha256 {entry['sha256'][:12]}..., got {digest[:12]}.... "
            "Restore the file or train it again."
        )
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {key: archive[key] for key in archive.files}
    except (ValueError, zipfile.BadZipFile, OSError) as error:
        raise ModelError(f"{path} is not a readable NumPy archive: {error}.") from None
    return Component(
        name,
        arrays,
        entry.get("params", {}),
        entry.get("data", {}),
        entry.get("figures", {}),
        entry.get("seed"),
        digest,
    )


def read_manifest(folder: Path) -> dict[str, Any]:
    """The manifest of a model folder.

    Raises:
        ModelError: missing, unreadable, or of another format.
    """
    path = folder / MANIFEST
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ModelError(
            f"There are no models in {folder}: {MANIFEST} is missing. Name a folder that `tsr train` made, or leave "
            "--models out for the shipped ones."
        ) from None
    except (OSError, ValueError) as error:
        raise ModelError(f"Cannot read {path}: {error}. Restore the file or train the models again.") from None
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        got = manifest.get("format") if isinstance(manifest, dict) else type(manifest).__name__
        raise ModelError(
            f"{path} has model format {got!r}, this version reads format {FORMAT}. Train the models again."
        )
    components = manifest.get("components")
    if not isinstance(components, dict) or not all(
        isinstance(c, dict) and isinstance(c.get("file"), str) and isinstance(c.get("sha256"), str)
        for c in components.values()
    ):
        raise ModelError(f"{path} is damaged: each of 'components' must name a file and its sha256.")
    return manifest


def save_component(component: Component, folder: Path) -> str:
    """Write one component and enter it into the folder's manifest, atomically; other components stay.

    Returns:
        The sha256 of the written file.

    Raises:
        StorageError: the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file = f"{component.name}.npz"
        temporary = folder / f".{file}.part"
        with temporary.open("wb") as stream:
            _write_npz(stream, component.arrays)
            stream.flush()
            os.fsync(stream.fileno())
        digest = hashlib.sha256(temporary.read_bytes()).hexdigest()
        temporary.replace(folder / file)
        manifest: dict[str, Any] = {"components": {}}
        if (folder / MANIFEST).exists():
            manifest = read_manifest(folder)
        manifest |= {"format": FORMAT, "engine": __version__}
        manifest["components"][component.name] = {
            "file": file,
            "sha256": digest,
            "params": dict(component.params),
            "data": dict(component.data),
            "figures": dict(component.figures),
            "seed": component.seed,
        }
        part = folder / f".{MANIFEST}.part"
        part.write_text(json.dumps(manifest, indent=1, sort_keys=True, allow_nan=False) + "\n", encoding="utf-8")
        part.replace(folder / MANIFEST)
    except OSError as error:
        raise StorageError(f"Cannot write the model folder {folder}: {error.strerror}.") from None
    return digest


def _write_npz(stream: Any, arrays: Mapping[str, NDArray[Any]]) -> None:
    """An ``.npz`` whose bytes depend on the arrays alone: sorted names and no time stamps."""
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for key in sorted(arrays):
            info = zipfile.ZipInfo(f"{key}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            info.compress_type = zipfile.ZIP_DEFLATED
            with archive.open(info, "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.ascontiguousarray(arrays[key]), allow_pickle=False)
