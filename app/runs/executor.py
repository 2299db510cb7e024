"""Runs the engine in the worker itself, or on a node of a Ray cluster.

In both cases a worker holds the job: its lock, heartbeat, fencing token and stored results. A node needs only the
files, and no database.
"""

from __future__ import annotations

import logging
import resource
import signal
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final

from app.jobs.context import Stopped, TaskContext
from app.jobs.exit_causes import exit_cause, exit_with_cause
from tsr_engine.batch.cluster import ClusterUnreachable
from tsr_engine.batch.node_runner import NodeLost, run_on_node
from tsr_engine.batch.node_task import NodeTask
from tsr_engine.pipeline import Components
from tsr_engine.runs.track_video import Progress, RunReport, RunRequest, track_video

RETRY_DELAY_S: Final = 2.0
"""Seconds between attempts to reach the cluster."""
_log = logging.getLogger("tsr.worker")


def run_engine(
    task: TaskContext,
    request: RunRequest,
    components: Components,
    models: Path | None,
    progress: Callable[[Progress], None],
) -> RunReport:
    """Track the video of a run on the machine of the setting ``executor``.

    A node that dies ends this process as a crash of the engine would: results so far are stored, the supervisor counts
    the death, and the next worker continues after the last stored frames.

    Args:
        task: the job.
        request: what to track.
        components: the models, loaded here.
        models: their folder; None: the shipped models.
        progress: called now and then.

    Raises:
        Stopped: the job was asked to stop.
        TsrError: the run has failed.
    """
    report: RunReport | None
    if task.settings.executor == "local":
        report = track_video(request, components, progress=progress, stop=task.should_stop)
    else:
        report = _on_ray(task, request, dict(components.models), models, progress)
    if report is None or report.interrupted:
        raise Stopped
    return report


def _on_ray(
    task: TaskContext,
    request: RunRequest,
    digests: dict[str, str],
    models: Path | None,
    progress: Callable[[Progress], None],
) -> RunReport | None:
    # Ray's client maps more memory than an engine may use, and the engine runs elsewhere
    resource.setrlimit(resource.RLIMIT_AS, (resource.getrlimit(resource.RLIMIT_AS)[1],) * 2)
    path = request.video if isinstance(request.video, Path) else request.video.path
    settings = task.settings
    node_task = NodeTask(
        replace(request, video=path, shared=True, cores=settings.cores or 1), models, digests, settings.worker_memory_mb
    )
    address = settings.executor.partition("://")[2] or None
    on_sigterm = signal.getsignal(signal.SIGTERM)
    noted = ""

    def stop() -> bool:
        signal.signal(signal.SIGTERM, on_sigterm)  # Ray's handler would end this process at once
        return task.should_stop()

    while True:
        try:
            return run_on_node(node_task, address, progress, stop, task.note)
        except ClusterUnreachable as error:
            if (note := f"waiting. {error}".rstrip(".")) != noted:
                _log.warning("%s The run waits for it.", error)
                task.note(note)
                noted = note
            if stop():
                return None
            time.sleep(RETRY_DELAY_S)
        except NodeLost as lost:
            _log.warning("Job %s: %s", task.job.id, lost)
            crashed = lost.code is not None and exit_cause(lost.code, out_of_memory=False) == "crashed"
            exit_with_cause("crashed" if crashed else "killed")
