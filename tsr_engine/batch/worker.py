"""Tracks one drive in its own process: ``python -m tsr_engine.batch.worker``.

The task comes on stdin; progress and outcome go to stdout, one line of JSON each.

The results are made in a hidden folder with a fixed name beside their destination. After a kill the next process
resumes the evidence after its last stored frame. The folder is renamed when all is complete.
"""

from __future__ import annotations

import fcntl
import json
import os
import shutil
import signal
import sys
import time
from pathlib import Path
from typing import Final

from tsr_engine.batch.child_process import exit_with_parent, limit_memory, require_models, send_message, send_note
from tsr_engine.batch.task import ANNOTATED_VIDEO, REPORT_FILE, DriveTask
from tsr_engine.compilation import report_compilation
from tsr_engine.errors import StorageError, TsrError
from tsr_engine.io.unfinished import fsync_path
from tsr_engine.json_shapes import JsonObject

_LOCK_TIMEOUT_S: Final = 60.0
"""Seconds to wait for another process that works on the same drive, because its machine may just have been lost."""
PROGRESS_INTERVAL_S: Final = 0.5
"""Seconds between two messages about the progress."""


def unfinished_folder(folder: Path) -> Path:
    """The hidden folder in which a drive's results are made."""
    return folder.with_name(f".{folder.name}.unfinished")


def main() -> None:
    """Read a task, run it, and report the outcome."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole process group; the parent decides
    exit_with_parent(os.getppid())
    try:
        task = DriveTask(**json.load(sys.stdin))
        limit_memory(task.memory_mb)
        send_message({"done": _track(task)})
    except TsrError as error:
        send_message({"failed": str(error)})
    except MemoryError:
        send_message({"failed": "The drive needs more memory than one process may use. Allow more with --memory-mb."})
    except Exception as error:  # noqa: BLE001 - the batch continues and reports it
        send_message(
            {"failed": f"Unexpected failure ({type(error).__name__}: {error}). Run `tsr track` on it to see more."}
        )


def _track(task: DriveTask) -> JsonObject:
    from tsr_engine.params import Params
    from tsr_engine.pipeline import Network, load_components
    from tsr_engine.runs.report_json import report_as_json
    from tsr_engine.runs.track_video import Progress, RunRequest, track_video

    folder = Path(task.folder)
    work = unfinished_folder(folder)
    params = Params.model_validate(task.parameters)
    network = None if task.onnx is None else Network(Path(task.onnx[0]), tuple(task.onnx[1]), task.onnx[2])
    components = load_components(params, None if task.models is None else Path(task.models), network)
    require_models(task.digests, components.models)
    try:
        work.mkdir(parents=True, exist_ok=True)
        lock = _lock(work)
    except OSError as error:
        raise StorageError(f"{work} cannot be written: {error.strerror}.") from None
    last_report = 0.0

    def show(progress: Progress) -> None:
        nonlocal last_report
        if time.monotonic() - last_report >= PROGRESS_INTERVAL_S:
            last_report = time.monotonic()
            send_message({"at": progress.done, "of": progress.total})

    request = RunRequest(
        Path(task.video),
        params,
        work / "evidence" if task.evidence else None,
        work / "tracks.csv" if task.csv else None,
        work / ANNOTATED_VIDEO if task.annotated else None,
        start=task.start,
        stop=task.stop,
        cores=task.cores,
    )
    try:
        with report_compilation(send_note, PROGRESS_INTERVAL_S):
            report = report_as_json(track_video(request, components, progress=show), request)
        for key, name in (("csv", "tracks.csv"), ("evidence", "evidence"), ("annotated", ANNOTATED_VIDEO)):
            report[key] = name if report[key] is not None else None
        report["stamp"] = task.stamp
        (work / REPORT_FILE).write_text(json.dumps(report, indent=1, allow_nan=False), encoding="utf-8")
        _publish(work, folder)
    except OSError as error:
        raise StorageError(f"{work} cannot be written: {error.strerror}.") from None
    finally:
        os.close(lock)
    return report


def _lock(work: Path) -> int:
    handle = os.open(work, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    deadline = time.monotonic() + _LOCK_TIMEOUT_S
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > deadline:
                os.close(handle)
                raise StorageError(f"Another process still works in {work}. Try again when it has ended.") from None
            time.sleep(0.2)
        else:
            return handle


def _publish(work: Path, folder: Path) -> None:
    """Rename the finished folder to its destination, replacing results of an earlier batch."""
    for path in sorted(work.rglob("*"), reverse=True):
        fsync_path(path)
    fsync_path(work)
    if folder.exists():
        shutil.rmtree(folder)
    work.rename(folder)
    fsync_path(folder.parent)


if __name__ == "__main__":
    main()
