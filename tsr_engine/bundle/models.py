"""Puts models into a bundle unless they ship with the package.

A model file is itself a ZIP archive, and careful unpackers refuse an archive inside another one. So the file is stored
after a line of text, and gets its name back when it is used.
"""

from __future__ import annotations

import shutil
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from tsr_engine.errors import ImportFormatError, ModelError
from tsr_engine.io.models import MANIFEST, SHIPPED, read_manifest

_HEADER_LINE = b"A model of tsr: a NumPy archive (.npz) follows this line.\n"
_SUFFIX = ".model"
_MAX_BYTES = 1 << 30
"""Largest unpacked size of a model's arrays, bytes."""


@dataclass(frozen=True, slots=True)
class ModelChoice:
    """The models of a run.

    Attributes:
        folder: folder to put in; None: none.
        text: one sentence for people.
    """

    folder: Path | None
    text: str


def choose_models(used: Mapping[str, str], folders: Iterable[Path]) -> ModelChoice:
    """Find the models of a run.

    Args:
        used: component -> sha256, from the run.
        folders: model folders to search, after the shipped one.
    """
    # A network is not part of a model folder; see ``tsr_engine.bundle.network``.
    used = {name: digest for name, digest in used.items() if not name.startswith("onnx ")}
    if _has_models(SHIPPED, used):
        return ModelChoice(None, "The run used the models that ship with the package.")
    for folder in folders:
        if _has_models(folder, used):
            return ModelChoice(folder, "The run used models of its own, which are inside.")
    unknown = sorted(name for name in used if name not in _hashes(SHIPPED))
    if unknown:
        return ModelChoice(None, f"The run used {unknown[0]!r}, which is not inside: name it again for a replay.")
    return ModelChoice(None, "The run used models that were not at hand when the bundle was made; they are not inside.")


def _has_models(folder: Path, used: Mapping[str, str]) -> bool:
    hashes = _hashes(folder)
    return bool(used) and all(hashes.get(name) == digest for name, digest in used.items())


def _hashes(folder: Path) -> dict[str, str]:
    try:
        return {name: str(entry["sha256"]) for name, entry in read_manifest(folder)["components"].items()}
    except ModelError:
        return {}


def add_models(source: Path, target: Path) -> None:
    """Copy a model folder into a bundle, as a new folder.

    Raises:
        ModelError: the manifest of the models is damaged.
    """
    target.mkdir()
    shutil.copyfile(source / MANIFEST, target / MANIFEST)
    for entry in read_manifest(source)["components"].values():
        with (source / entry["file"]).open("rb") as stream, (target / f"{entry['file']}{_SUFFIX}").open("wb") as out:
            out.write(_HEADER_LINE)
            shutil.copyfileobj(stream, out)


def extract_models(source: Path, target: Path) -> Path:
    """Copy the models of a bundle into a model folder, under their own names; returns ``target``.

    Raises:
        ImportFormatError: a model is missing, is not a model file, or unfolds to too much.
        ModelError: the manifest of the models is damaged.
    """
    target.mkdir(parents=True, exist_ok=True)
    components = read_manifest(source)["components"]
    shutil.copyfile(source / MANIFEST, target / MANIFEST)
    for name, entry in components.items():
        file = str(entry["file"])
        stored = source / f"{file}{_SUFFIX}"
        if Path(file).name != file or not stored.is_file():
            raise ImportFormatError(f"The bundle lacks its model {name[:80]!r}. Create it again.")
        with stored.open("rb") as stream, (target / file).open("wb") as out:
            if stream.read(len(_HEADER_LINE)) != _HEADER_LINE:
                raise ImportFormatError(f"models/{stored.name} in the bundle is not a model. Create the bundle again.")
            shutil.copyfileobj(stream, out)
        _check_size(target / file)
    return target


def _check_size(path: Path) -> None:
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
    except (zipfile.BadZipFile, ValueError, NotImplementedError):
        raise ImportFormatError(
            f"models/{path.name} in the bundle is not a NumPy archive. Create the bundle again."
        ) from None
    if size > _MAX_BYTES:
        raise ImportFormatError(
            f"models/{path.name} in the bundle unfolds to {size} bytes, more than the {_MAX_BYTES} allowed."
        )
