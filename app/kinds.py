"""The kinds of jobs of the review tool: who does them, and what becomes of a job that does not end well.

A new kind is an entry here; the queue (``app.jobs``) knows none of them.
"""

from __future__ import annotations

from functools import partial
from typing import Final

from app.jobs.kinds import JobKind, JobKinds, Task
from app.on_job_failed import on_job_failed
from app.outputs.folders import clear_folder
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Follow, ModelVersion, Output, Run, Video
from tsr_engine.json_shapes import JsonObject

__all__ = ["KINDS"]


def _recording() -> Task:
    from app.recordings.task import record_run

    return record_run


def _sdk() -> None:
    from tsr_engine.recording.write import load_sdk

    load_sdk()


def _whatif() -> Task:
    from app.whatif.task import run_whatif

    return run_whatif


def _follow() -> Task:
    from app.follows.task import follow_track

    return follow_track


def _follower() -> None:
    from app.follows.task import warm

    warm()


def _follow_soon(settings: Settings, database: Database, about: JsonObject) -> None:
    from app.follows.soon import get_ready

    get_ready(settings, database, about["run"], about["frame"])


def _import() -> Task:
    from app.runs.start import queue_first_runs
    from app.videos.importing import import_video

    return partial(import_video, sample_ready=queue_first_runs)


def _export() -> Task:
    from app.exchange.task import export

    return export


def _bundle() -> Task:
    from app.bundles.task import make_run_bundle

    return make_run_bundle


def _scene() -> Task:
    from app.scene3d.task import make_scene

    return make_scene


def _track() -> Task:
    from app.runs.task import track

    return track


def _retrain() -> Task:
    from app.exchange.reviews import export_reviews
    from app.training.task import retrain_models

    return partial(retrain_models, export_reviews=export_reviews)


_output_failed = partial(on_job_failed, Output)
_run_failed = partial(on_job_failed, Run)

KINDS: Final = JobKinds(
    (
        JobKind("follow", "short", _follow, partial(on_job_failed, Follow), prepare=(_follower,), expect=_follow_soon),
        JobKind("recording", "short", _recording, _output_failed, clear_folder, prepare=(_sdk,)),
        JobKind("whatif", "short", _whatif, _run_failed),
        JobKind("import", "imports", _import, partial(on_job_failed, Video), by_frame=True),
        JobKind("export", "short", _export, _output_failed, clear_folder),
        JobKind("bundle", "short", _bundle, _output_failed, clear_folder),
        JobKind("scene", "short", _scene, _output_failed, clear_folder),
        JobKind("track", "long", _track, _run_failed, by_frame=True),
        JobKind("retrain", "long", _retrain, partial(on_job_failed, ModelVersion)),
    ),
    worker="app.worker",
)
"""Never changed."""
