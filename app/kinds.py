"""The kinds of jobs of the review tool: who does them, and what becomes of a job that does not end well.

A new kind is an entry here; the queue (``app.jobs``) knows none of them.
"""

from __future__ import annotations

from functools import partial
from typing import Final

from app.artefacts.folders import clear_folder
from app.artefacts.settling import settle_artefact
from app.follows.settling import settle_follow
from app.jobs.kinds import JobKind, JobKinds, Task
from app.runs.settling import settle_run
from app.training.settling import settle_version
from app.videos.settling import settle_video

__all__ = ["KINDS"]


def _recording() -> Task:
    from app.recordings.task import record_run

    return record_run


def _recorder() -> None:
    import tsr_engine.recording  # noqa: F401


def _sdk() -> None:
    from tsr_engine.recording.sink import load_sdk

    load_sdk()


def _whatif() -> Task:
    from app.whatif.task import run_whatif

    return run_whatif


def _replay() -> None:
    import tsr_engine.replay  # noqa: F401


def _follow() -> Task:
    from app.follows.task import follow_track

    return follow_track


def _follower() -> None:
    from app.follows.task import warm

    warm()


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
    from app.space.task import make_scene

    return make_scene


def _track() -> Task:
    from app.runs.task import track

    return track


def _retrain() -> Task:
    from app.training.task import retrain_models

    return retrain_models


KINDS: Final = JobKinds(
    (
        JobKind("follow", "short", _follow, settle_follow, prepare=(_follower,)),
        JobKind("recording", "short", _recording, settle_artefact, clear_folder, prepare=(_recorder, _sdk)),
        JobKind("whatif", "short", _whatif, settle_run, prepare=(_replay,)),
        JobKind("import", "imports", _import, settle_video, by_frame=True),
        JobKind("export", "short", _export, settle_artefact, clear_folder),
        JobKind("bundle", "short", _bundle, settle_artefact, clear_folder),
        JobKind("scene", "short", _scene, settle_artefact, clear_folder),
        JobKind("track", "long", _track, settle_run, by_frame=True),
        JobKind("retrain", "long", _retrain, settle_version),
    ),
    worker="app.worker",
)
"""Never changed."""
