"""Finds the spatial prior of a run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from sqlalchemy import select

from app.files.shared import ensure_local
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import ModelVersion, Run
from tsr_engine.detection.prior import SpatialPrior
from tsr_engine.errors import TsrError
from tsr_engine.io.models import SHIPPED, load_component, read_manifest


@dataclass(frozen=True, slots=True)
class Prior:
    """A prior; ``is_of_run``: whether the run was made with it."""

    prior: SpatialPrior
    is_of_run: bool


def find_prior(settings: Settings, database: Database, run_id: str) -> Prior | None:
    """Find the prior that a run names by its hash, in the server's models and in all trained ones.

    Returns:
        That prior; if it no longer exists, the server's; None if the server's models have none.
    """
    with database.read() as session:
        run = session.get(Run, run_id)
        digest = None if run is None else run.models.get("prior")
        versions = session.scalars(select(ModelVersion).where(ModelVersion.state == "complete")).all()
        others = [v for v in versions if digest and v.models.get("prior") == digest]
    current = _load(settings.models)
    if current is not None and current[1] == digest:
        return Prior(current[0], True)
    for version in others:
        found = _load(ensure_local(settings, version.place, version.folder))
        if found is not None and found[1] == digest:
            return Prior(found[0], True)
    return None if current is None else Prior(current[0], digest is None)


def _load(folder: Path | None) -> tuple[SpatialPrior, str] | None:
    """A folder's prior and its hash; None: there is no readable one."""
    try:
        if "prior" not in read_manifest(SHIPPED if folder is None else folder)["components"]:
            return None
        component = load_component("prior", folder)
        table = component.arrays["table"].astype(np.float32)
        return SpatialPrior(table, float(component.params["lambda"])), component.sha256
    except (TsrError, KeyError, ValueError, TypeError):
        return None
