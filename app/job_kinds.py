"""The kinds of jobs of the review tool: their tasks, and what happens to a job that fails.

A new kind is an entry here; the queue (``app.jobs``) knows none of them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pkgutil import resolve_name
from typing import Final

from app.job_subjects import on_job_failed, on_job_note
from app.jobs.kinds import JobKinds
from app.jobs.tasks import Task, TaskKind
from app.outputs.folders import clear_folder
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Follow, ModelVersion, Output, Run, Video
from app.training.folders import clear_training_pictures
from app.videos.import_files import clear_import
from tsr_engine.json_shapes import JsonObject


def _task(name: str) -> Callable[[], Task]:
    """Import the task ``module:function`` when it is called: only the worker that runs it loads the engine."""
    return partial(resolve_name, name)


def _prepare(name: str) -> Callable[[], object]:
    """Import ``module:function`` and call it."""
    return lambda: resolve_name(name)()


def _expect(name: str) -> Callable[[Settings, Database, JsonObject], None]:
    """Import ``module:function`` and call it with what is known of a job that may come."""
    return lambda settings, database, known: resolve_name(name)(settings, database, **known)


_output_failed = partial(on_job_failed, Output)
_run_failed = partial(on_job_failed, Run)
_run_noted = partial(on_job_note, Run)

KINDS: Final = JobKinds(
    (
        TaskKind(
            "follow",
            "short",
            partial(on_job_failed, Follow),
            load=_task("app.follows.task:follow_track"),
            prepare=(_prepare("app.follows.task:warm"),),
            expect=_expect("app.follows.prepared_video:prepare_video"),
            on_note=partial(on_job_note, Follow),
        ),
        TaskKind(
            "recording",
            "short",
            _output_failed,
            clear_folder,
            load=_task("app.recordings.task:record_run"),
            prepare=(_prepare("tsr_engine.recording.write:load_sdk"),),
        ),
        TaskKind("whatif", "short", _run_failed, load=_task("app.whatif.task:run_whatif"), on_note=_run_noted),
        TaskKind(
            "import",
            "imports",
            partial(on_job_failed, Video),
            clear_import,
            load=_task("app.runs.import_task:import_and_start"),
            by_frame=True,
        ),
        TaskKind("export", "short", _output_failed, clear_folder, load=_task("app.exchange.task:export")),
        TaskKind("bundle", "short", _output_failed, clear_folder, load=_task("app.bundles.task:make_run_bundle")),
        TaskKind("scene", "scenes", _output_failed, clear_folder, load=_task("app.scene3d.task:make_scene")),
        TaskKind("track", "long", _run_failed, load=_task("app.runs.task:track"), on_note=_run_noted, by_frame=True),
        TaskKind(
            "retrain",
            "long",
            partial(on_job_failed, ModelVersion),
            clear_training_pictures,
            load=_task("app.exchange.retrain_task:retrain"),
            on_note=partial(on_job_note, ModelVersion),
        ),
    ),
    worker="app.worker",
)
"""Never changed."""
