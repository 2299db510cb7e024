"""Requests what-ifs."""

from __future__ import annotations

import uuid
from collections.abc import Mapping

from sqlalchemy.orm import Session

from app.errors import Conflict, Invalid
from app.events import EventBus
from app.jobs.queue import JobQueue
from app.runs.parameters import params_of, present_parameters
from app.runs.view import publish_run
from app.storage.database import Database
from app.storage.lookup import ACTIVE, require_run
from app.storage.models import Run
from app.storage.servers import require_local
from tsr_engine.errors import UsageError
from tsr_engine.params import Params
from tsr_engine.params.replayable import changed_parameters, is_replayable, refuse_missing_focus
from tsr_engine.version import __version__

PRIORITY = 20
"""Priority before waiting runs and imports, because a replay takes seconds and a person waits for it."""


class WhatIfService:
    """Starts what-ifs."""

    def __init__(self, database: Database, events: EventBus, jobs: JobQueue) -> None:
        self._database = database
        self._events = events
        self._jobs = jobs

    def start(self, run_id: str, parameters: Mapping[str, object], name: str = "") -> Run:
        """Queue a replay of a run with some parameters changed.

        A what-if of a what-if takes over its parameters and replays the original run, because only that run has pixels.

        Raises:
            NotFound: no such run.
            Conflict: the run is not complete, or was imported.
            Invalid: a parameter is unknown, out of range or used by a step that a replay does not repeat, or nothing
                changes.
        """
        parameters = present_parameters(parameters)
        with self._database.write() as session:
            requested = require_run(session, run_id)
            origin = _origin(session, requested)
            require_local(session, origin.place, origin.name)
            _require_replayable(origin)
            before = params_of(origin.preset, origin.parameters)
            merged = {**present_parameters(requested.parameters), **parameters}
            params = params_of(origin.preset, merged)
            _require_changes(before, params, parameters)
            run = Run(
                id=uuid.uuid4().hex,
                video_id=origin.video_id,
                kind="whatif",
                name=name or _title(before, params),
                parent_id=origin.id,
                preset=origin.preset,
                parameters=merged,
                first=origin.first,
                stop=origin.stop,
                frames_total=origin.frames_done,
                engine_version=__version__,
                models=dict(origin.models),
            )
            run.folder = f"runs/{run.id}"
            session.add(run)
            session.flush()
            self._jobs.submit(session, "whatif", run.id, priority=PRIORITY)
            publish_run(session, self._events, run)
        return run


def _origin(session: Session, run: Run) -> Run:
    """The engine's run at the start of a chain of what-ifs."""
    while run.kind == "whatif" and run.parent_id is not None:
        run = session.get_one(Run, run.parent_id)
    return run


def _require_replayable(run: Run) -> None:
    if run.kind == "imported":
        raise Conflict(f"{run.name} was imported, so it has no evidence to replay.", code="not_replayable")
    if run.state in ACTIVE:
        raise Conflict(f"{run.name} is still {run.state}. Wait until it is complete.", code="still_running")


def _require_changes(before: Params, params: Params, requested: Mapping[str, object]) -> None:
    """Refuse changes that a replay cannot make, naming the parameter as in the request."""
    given_names = {name.rpartition(".")[2]: name for name in requested}
    changed = changed_parameters(before, params)
    for name in changed:
        if not is_replayable(name):
            leaf = name.rpartition(".")[2]
            raise Invalid(
                f"A what-if cannot change {leaf}: it takes the run's own detections and camera shifts. Start a new run "
                "with it instead.",
                field=f"parameters.{given_names.get(leaf, leaf)}",
                code="not_replayable",
            )
    try:
        refuse_missing_focus(before, params)
    except UsageError as error:
        raise Invalid(str(error), field="parameters.coast_foe_y", code="not_replayable") from None
    if not changed:
        raise Invalid(
            "The run already has these parameters, so nothing would change. Choose other values.",
            field="parameters",
            code="nothing_changes",
        )


def _title(before: Params, after: Params) -> str:
    """A short name such as ``tau = 20, search_radius = 40``."""
    values = after.model_dump()
    parts = []
    for name in changed_parameters(before, after):
        section, leaf = name.split(".")
        parts.append(f"{leaf} = {_format_value(values[section][leaf])}")
    text = ", ".join(parts)
    return text if len(text) <= 80 else f"{text[:77]}..."


def _format_value(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(map(_format_value, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
