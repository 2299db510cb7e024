"""Checks what this installation has and lacks, and how to get what is missing."""

from __future__ import annotations

import importlib.metadata
import os
import re
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tsr_engine.errors import ModelError
from tsr_engine.extras import EXTRAS
from tsr_engine.io.cores import usable_cores
from tsr_engine.io.models import SHIPPED, load_component, read_manifest
from tsr_engine.labels.classes import classes_of_keys
from tsr_engine.labels.files import DEFAULT, shipped_set
from tsr_engine.version import __version__

Status = Literal["ok", "warning", "missing"]

_MIN_PYTHON = (3, 11)
_COMPONENTS = ("detector", "prior", "classifier")
CODECS: tuple[tuple[str, str, Status], ...] = (
    ("h264", "r", "missing"),
    ("libx264", "w", "missing"),
    ("hevc", "r", "warning"),
    ("vp9", "r", "warning"),
    ("mjpeg", "r", "warning"),
)
MIN_MEMORY_GIB = 2.0
_REINSTALL = "Install tsr again from its wheel or checkout, with pip install --force-reinstall."


@dataclass(frozen=True, slots=True)
class Check:
    """The result of one check.

    Attributes:
        name: the checked item.
        status: ``ok``, ``warning`` (works with limits) or ``missing`` (something will fail).
        found: what was found.
        advice: how to get the missing item; empty: nothing is missing.
    """

    name: str
    status: Status
    found: str
    advice: str = ""


def diagnose(models: Path | None = None) -> list[Check]:
    """All checks of this installation, in reading order.

    Args:
        models: the model folder to check; unset: the shipped models.
    """
    return [
        _python(),
        Check("tsr", "ok", __version__),
        *_packages(),
        *_codecs(),
        Check("cores", "ok", str(usable_cores())),
        _memory(),
        _numba_cache(),
        *_models(SHIPPED if models is None else models),
    ]


def _python() -> Check:
    found = ".".join(str(part) for part in sys.version_info[:3])
    if sys.version_info[:2] >= _MIN_PYTHON:
        return Check("python", "ok", found)
    return Check("python", "missing", found, f"Install Python {_MIN_PYTHON[0]}.{_MIN_PYTHON[1]} or newer.")


def _packages() -> Iterator[Check]:
    """Every dependency in the package's metadata, with its lower bound; then each extra as a whole."""
    try:
        requirements = importlib.metadata.requires("tsr") or []
    except importlib.metadata.PackageNotFoundError:
        yield Check("packages", "warning", "tsr is not installed, only on the path", "pip install .")
        return
    missing: dict[str, list[str]] = {extra: [] for extra in EXTRAS}
    for line in requirements:
        requirement, _, marker = (part.strip() for part in line.partition(";"))
        extra = match[1] if (match := re.search(r"extra == ['\"]([\w-]+)['\"]", marker)) else None
        if marker and extra not in missing:  # only for development, or another system
            continue
        # "name>=1.2,<2" or, as written into some metadata, "name<2,>=1.2"
        name = re.split(r"[<>=!~\[ ]", requirement, maxsplit=1)[0]
        lower = re.search(r">=\s*([0-9.]+)", requirement)
        bound = lower[1] if lower else ""
        try:
            found = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            if extra is None:
                yield Check(name, "missing", "not installed", f'pip install "{requirement}"')
            else:
                missing[extra].append(name)
            continue
        if _numbers(found) < _numbers(bound):
            yield Check(name, "missing", f"{found}, older than {bound}", f'pip install "{requirement}"')
        else:
            yield Check(name, "ok", found)
    for extra, names in missing.items():
        if names:
            found = f"without {', '.join(names)}"
            yield Check(f"extra {extra}", "warning", found, f"pip install 'tsr[{extra}]'")
        else:
            yield Check(f"extra {extra}", "ok", "installed")


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r"\d+", version.split("+")[0])[:4])


def _codecs() -> Iterator[Check]:
    try:
        import av
    except ImportError as error:
        yield Check("codecs", "missing", str(error), "pip install --force-reinstall av")
        return
    for codec, mode, status_if_missing in CODECS:
        purpose = "decode" if mode == "r" else "encode"
        try:
            av.Codec(codec, mode)
        except (ValueError, av.FFmpegError):
            yield Check(
                f"{codec} ({purpose})",
                status_if_missing,
                "not in this build of PyAV",
                "pip install --only-binary av av",
            )
        else:
            yield Check(f"{codec} ({purpose})", "ok", "available")


def _memory() -> Check:
    """Available memory, known only on Linux without a further dependency."""
    try:
        text = Path("/proc/meminfo").read_text(encoding="ascii")
        available = int(text.split("MemAvailable:")[1].split()[0]) / 2**20
    except (OSError, IndexError, ValueError):
        return Check("memory", "ok", "unknown on this system")
    found = f"{available:.1f} GiB available"
    if available >= MIN_MEMORY_GIB:
        return Check("memory", "ok", found)
    return Check("memory", "warning", found, f"Close other programs until {MIN_MEMORY_GIB:.0f} GiB are free.")


def _numba_cache() -> Check:
    """Compiled code is cached where the user says, beside the package, or in a cache folder; Numba needs a place."""
    name, advice = "compiled code cache", "Set NUMBA_CACHE_DIR to a folder that can be written."
    configured = os.environ.get("NUMBA_CACHE_DIR")
    home_cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folders = [*([Path(configured)] if configured else []), SHIPPED.parent, home_cache]
    used = next((folder for folder in folders if _is_writable(folder)), None)
    if used is None:
        return Check(name, "missing", f"{' and '.join(map(str, folders))} cannot be written", advice)
    if configured and used != folders[0]:
        return Check(name, "warning", f"{configured} cannot be written, so {used} is used", advice)
    return Check(name, "ok", str(used))


def _is_writable(folder: Path) -> bool:
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    try:
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _models(folder: Path) -> Iterator[Check]:
    advice = "tsr train all --gtsdb DIR --gtsrb DIR --out MODELS" if folder != SHIPPED else _REINSTALL
    try:
        names = set(read_manifest(folder)["components"])
    except ModelError as error:
        yield Check("models", "missing", str(error), advice)
        return
    for name in sorted(names | set(_COMPONENTS)):
        try:
            component = load_component(name, folder)
        except ModelError as error:
            yield Check(f"model {name}", "missing", str(error), advice)
        else:
            yield Check(f"model {name}", "ok", f"sha256 {component.sha256[:12]}")
            if name == "classifier" and (keys := component.params.get("labels")) is not None:
                yield Check("labels of the classifier", "ok", _labels(keys))


def _labels(keys: list[str]) -> str:
    """The number of a classifier's labels, and the shipped signs that it lacks."""
    missing = [label.key for label in classes_of_keys(keys, shipped_set(DEFAULT)).labels_without_class()]
    if not missing:
        return f"{len(keys)}; all of {DEFAULT}"
    return f"{len(keys)}; of {DEFAULT} it lacks {len(missing)}: {', '.join(missing)}"
