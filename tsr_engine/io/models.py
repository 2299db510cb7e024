"""Models on disk: one NumPy archive a component and a manifest that names and hashes them. Never pickle.

::

    MODELS/
      manifest.json                  {"format": 2, "components": {"detector": {...}, "prior": {...}, ...}}
      detector-35901bd4c0de.npz      plain arrays
      ...

A component of the manifest has ``file``, ``sha256``, ``params`` (values that inference needs besides the arrays),
``data`` (its training data), ``figures`` (held-out results) and ``seed``.

An array file is named after its content and never overwritten. The manifest is replaced in one step and names the old
files until then. Shipped files have other names; the manifest decides.
"""

from __future__ import annotations

import hashlib
import io
import json
import math
import re
import tokenize
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import ModelError
from tsr_engine.io.atomic import atomic_bytes, atomic_text
from tsr_engine.io.unfinished import remove_leftovers
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.version import __version__

FORMAT = 2
MANIFEST = "manifest.json"
MAX_BYTES = 1 << 30
"""Largest unpacked size of a component in bytes; the largest shipped one has 13 MB."""
ARCHIVE_ERRORS = (
    *(ValueError, EOFError, NotImplementedError, zipfile.BadZipFile, zlib.error, OSError),
    *(SyntaxError, tokenize.TokenError, RecursionError),
)
"""Exceptions of ``zipfile`` and NumPy for bytes that are not an archive of arrays; an array's header is Python text."""
SHIPPED = Path(__file__).resolve().parent.parent / "models"


@dataclass(frozen=True, slots=True)
class Component:
    """One trained part: arrays, parameters for inference, and origin."""

    name: str
    arrays: Mapping[str, NDArray[np.generic]]
    params: JsonMapping = field(default_factory=dict)
    data: JsonMapping = field(default_factory=dict)
    figures: JsonMapping = field(default_factory=dict)
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
    entry, path = _entry(name, folder)
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
        arrays = _arrays(content)
    except ARCHIVE_ERRORS as error:
        raise ModelError(f"{path} is not a readable NumPy archive: {error}.") from None
    except MemoryError:
        raise ModelError(f"{path} holds an array that does not fit into memory.") from None
    return Component(
        name,
        arrays,
        entry.get("params", {}),
        entry.get("data", {}),
        entry.get("figures", {}),
        entry.get("seed"),
        digest,
    )


def _arrays(content: bytes) -> dict[str, NDArray[np.generic]]:
    """Read the arrays of a NumPy archive; object arrays are refused.

    Raises:
        Exception: those of ``zipfile`` and NumPy; also ``ValueError`` if the arrays unfold to too much.
    """
    with np.load(io.BytesIO(content), allow_pickle=False) as archive:
        unpacked_bytes = sum(member.file_size for member in archive.zip.infolist())
        if unpacked_bytes > MAX_BYTES:
            raise ValueError(f"it unfolds to {unpacked_bytes} bytes, allowed are {MAX_BYTES}")
        return {key: archive[key] for key in archive.files}


def component_path(name: str, folder: Path | None = None) -> Path:
    """The path of a component's array file; the file itself is not read.

    Args:
        name: name of the component.
        folder: a model folder; unset: the models shipped with the package.

    Raises:
        ModelError: no manifest, another format, or missing component.
    """
    return _entry(name, SHIPPED if folder is None else folder)[1]


def _entry(name: str, folder: Path) -> tuple[JsonMapping, Path]:
    """A component's entry in the manifest, and its file."""
    entry = read_manifest(folder)["components"].get(name)
    if entry is None:
        raise ModelError(f"The models in {folder} have no component '{name}'. Train one with `tsr train`.")
    path = folder / str(entry["file"])
    if path.parent != folder:
        raise ModelError(f"Component '{name}' in {folder} names a file outside the folder: {entry['file']}.")
    return entry, path


def read_manifest(folder: Path) -> JsonObject:
    """Read the manifest of a model folder.

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
    except (OSError, ValueError, RecursionError) as error:
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
    """Write one component and add it to the folder's manifest; other components stay.

    If this stops at any point, the folder holds the old or the new component. Files of the component that the manifest
    no longer names are removed at the end.

    Returns:
        The sha256 of the written file.

    Raises:
        ModelError: the existing manifest cannot be read, or a number of the component is not finite.
        StorageError: the folder cannot be written.
    """
    arrays = io.BytesIO()
    _write_npz(arrays, component.arrays)
    content = arrays.getvalue()
    digest = hashlib.sha256(content).hexdigest()
    manifest: JsonObject = {"components": {}}
    if (folder / MANIFEST).exists():
        manifest = read_manifest(folder)
    manifest |= {"format": FORMAT, "engine": __version__}
    old_file = manifest["components"].get(component.name, {}).get("file")
    manifest["components"][component.name] = {
        "file": f"{component.name}-{digest[:12]}.npz",
        "sha256": digest,
        "params": dict(component.params),
        "data": dict(component.data),
        "figures": dict(component.figures),
        "seed": component.seed,
    }
    text = _manifest_text(manifest, component)
    with atomic_bytes(folder / f"{component.name}-{digest[:12]}.npz") as out:
        out.write(content)
    with atomic_text(folder / MANIFEST) as file:
        file.write(text)
    _remove_old_files(component.name, old_file, folder, {entry["file"] for entry in manifest["components"].values()})
    return digest


def _manifest_text(manifest: JsonMapping, component: Component) -> str:
    for part in ("params", "data", "figures"):
        for key_path, value in _floats_in(getattr(component, part), part):
            if not math.isfinite(value):
                raise ModelError(
                    f"Expected finite numbers in the component '{component.name}'. Got {value} for {key_path}: it was "
                    "not written. Train it again with other data or another seed."
                )
    return json.dumps(manifest, indent=1, sort_keys=True, allow_nan=False) + "\n"


def _floats_in(value: object, key_path: str) -> Iterator[tuple[str, float]]:
    """Yield every float in nested JSON values with its place: ``figures.size.small``."""
    if isinstance(value, float):
        yield key_path, value
    elif isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _floats_in(inner, f"{key_path}.{key}")
    elif isinstance(value, list | tuple):
        for k, inner in enumerate(value):
            yield from _floats_in(inner, f"{key_path}.{k}")


def _remove_old_files(name: str, old_file: str | None, folder: Path, current_files: set[str]) -> None:
    """Remove a component's earlier file and leftovers of killed writers; a leftover does no harm."""
    own_name = rf"{re.escape(name)}-[0-9a-f]{{12}}\.npz"
    with suppress(OSError):
        for path in list(folder.iterdir()):
            if path.name not in current_files and (path.name == old_file or re.fullmatch(own_name, path.name)):
                path.unlink(missing_ok=True)
            elif unfinished := re.match(rf"\.({own_name})\.", path.name):
                remove_leftovers(folder / unfinished[1])


def _write_npz(stream: IO[bytes], arrays: Mapping[str, NDArray[np.generic]]) -> None:
    """Write an ``.npz`` whose bytes depend only on the arrays: sorted names and no time stamps."""
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for key in sorted(arrays):
            info = zipfile.ZipInfo(f"{key}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            info.compress_type = zipfile.ZIP_DEFLATED
            with archive.open(info, "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.ascontiguousarray(arrays[key]), allow_pickle=False)
