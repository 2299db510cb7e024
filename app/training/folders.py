"""Folders of the models of a version and of a run; a run keeps the models that it started with.

A run records the hashes of its models, by which its version is found again.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.files.shared import ensure_local
from app.settings import Settings
from app.storage.models import ModelVersion, Run
from app.storage.servers import has_local_files, is_local
from tsr_engine.errors import EvidenceError, ModelError
from tsr_engine.evidence import EvidenceReader
from tsr_engine.evidence.schema import RUN_FILE
from tsr_engine.io.models import SHIPPED, read_manifest
from tsr_engine.json_shapes import JsonObject

SHIPPED_ID: Final = "shipped"
"""Name of a server's models without any training: those of the package, or of the setting ``models``."""
RUN_COMPONENTS: Final[tuple[str, ...]] = ("detector", "prior", "classifier", "network_classifier", "online")
"""Components that a run uses and records."""


def working_folder(home: Path, version_id: str) -> Path:
    """The folder of unpacked exports and decoded pictures while a version is trained."""
    return home / "models" / f"{version_id}.work"


def clear_training_pictures(home: Path, version_id: str) -> None:
    """Remove what a killed training has decoded, up to gigabytes; the parts that it has finished are kept."""
    shutil.rmtree(working_folder(home, version_id), ignore_errors=True)


def active_version(session: Session) -> ModelVersion | None:
    """Return the version that new runs use; None: the shipped one."""
    query = (
        select(ModelVersion)
        .where(ModelVersion.state == "complete", ModelVersion.promoted > 0)
        .order_by(ModelVersion.promoted.desc())
        .limit(1)
    )
    return session.scalars(query).first()


def hashes_of(folder: Path | None) -> dict[str, str]:
    """Return the hashes, from the manifest of a model folder, of the components that a run uses; unset: the package's.

    Raises:
        ModelError: the manifest is missing or unreadable.
    """
    components: JsonObject = read_manifest(SHIPPED if folder is None else folder)["components"]
    return {name: str(components[name]["sha256"]) for name in RUN_COMPONENTS if name in components}


def models_for_start(settings: Settings, session: Session, run: Run) -> Path | None:
    """Return the model folder for a run that starts or resumes; the run records the models that it starts with.

    Raises:
        ModelError: the models that it started with no longer exist.
    """
    known = {name: run.models[name] for name in RUN_COMPONENTS if name in run.models} or _recorded(
        settings.home / run.folder
    )
    if known:
        folder = folder_with_hashes(settings, session, known, run.name or "The run")
    else:
        version = active_version(session)
        if version is not None and not has_local_files(session, version.place):
            raise ModelError(
                f"The models {version.name}, which new runs use, lie on another server. Promote others where this "
                "video lies, or train them there."
            )
        folder = settings.models if version is None else ensure_local(settings, version.place, version.folder)
        known = hashes_of(folder)
    run.models = {**run.models, **known}
    return folder


def models_of_run(settings: Settings, session: Session, run: Run) -> Path | None:
    """Return the model folder that a run was made with; the server's if the run names none.

    Raises:
        ModelError: it no longer exists.
    """
    known = {name: run.models[name] for name in RUN_COMPONENTS if name in run.models}
    return folder_with_hashes(settings, session, known, run.name or "The run") if known else settings.models


def folder_with_hashes(settings: Settings, session: Session, wanted: Mapping[str, str], who: str) -> Path | None:
    """Return the folder whose models have these hashes; None: the package's.

    Raises:
        ModelError: there is none.
    """
    for folder in (settings.models, None):
        if _has(hashes_of(folder), wanted):
            return folder
    conditions = ModelVersion.state == "complete", is_local(session, ModelVersion.place)
    for version in session.scalars(select(ModelVersion).where(*conditions)):
        if _has(version.models, wanted):
            return ensure_local(settings, version.place, version.folder)
    listed = ", ".join(f"{name} {digest[:12]}" for name, digest in sorted(wanted.items()))
    raise ModelError(
        f"{who} was started with models that no longer exist here ({listed}). Start tsr review with "
        "--models and their folder, or start a new run."
    )


def _has(models: Mapping[str, str], wanted: Mapping[str, str]) -> bool:
    return all(models.get(name) == digest for name, digest in wanted.items())


def _recorded(folder: Path) -> dict[str, str]:
    """Hashes in a run's evidence; empty: it has none yet."""
    if not (folder / RUN_FILE).is_file():
        return {}
    try:
        with EvidenceReader(folder) as reader:
            return {name: digest for name, digest in reader.header.models.items() if name in RUN_COMPONENTS}
    except EvidenceError:
        return {}  # the run itself reports what is wrong
