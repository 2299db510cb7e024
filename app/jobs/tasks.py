"""What a worker can do."""

from __future__ import annotations

from collections.abc import Callable

from app.jobs.context import TaskContext

__all__ = ["Task", "task_of"]

Task = Callable[[TaskContext], None]


def task_of(kind: str) -> Task:
    """The function for a kind of job; imported when it is needed, for the engine is large.

    Raises:
        KeyError: there is no such kind.
    """
    if kind == "import":
        from app.videos.importing import import_video

        return import_video
    if kind == "track":
        from app.runs.task import track

        return track
    if kind == "retrain":
        from app.training.task import retrain_models

        return retrain_models
    if kind == "export":
        from app.exchange.task import export

        return export
    if kind == "whatif":
        from app.whatif.task import run_whatif

        return run_whatif
    if kind == "bundle":
        from app.bundles.task import make_run_bundle

        return make_run_bundle
    if kind == "recording":
        from app.recordings.task import record_run

        return record_run
    if kind == "scene":
        from app.space.task import make_scene

        return make_scene
    raise KeyError(kind)
