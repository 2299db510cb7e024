"""A batch on two Ray nodes, one of which is killed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tsr_engine.batch.manifest import Identity
from tsr_engine.batch.run import BatchProgress, BatchRequest, run_batch
from tsr_engine.batch.task import DriveTask
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components
from tsr_engine.version import __version__

__all__ = ["PARAMS", "run_killed_batch"]

PARAMS = Params().with_settings([("coast_foe_y", 0.5)])


def run_killed_batch(drives: Path, out: Path, kill_node: Callable[[], None]) -> dict[str, object]:
    """Run a batch, kill a node after the first drive, and run the batch again.

    Args:
        drives: folder of the drives.
        out: folder of the results.
        kill_node: kills a node of the cluster.
    """
    digests = dict(load_components(PARAMS).models)
    parameters = PARAMS.model_dump(mode="json")
    request = BatchRequest(
        sorted(drives.glob("*.mp4")),
        out,
        Identity(__version__, parameters, digests),
        DriveTask("", "", parameters, digests=digests),
        "ray",
    )
    killed_after: list[int] = []

    def kill_one(at: BatchProgress) -> None:
        if not killed_after:
            killed_after.append(at.done)
            kill_node()

    manifest = run_batch(request, kill_one, lambda: False)
    stamps = {str(p): p.stat().st_mtime_ns for p in out.glob("*/**/*")}
    reported: list[BatchProgress] = []
    run_batch(request, reported.append, lambda: False)
    again = {str(p): p.stat().st_mtime_ns for p in out.glob("*/**/*")}
    return {
        "killed_after": killed_after,
        "states": {drive.folder: [drive.state, drive.error] for drive in manifest.drives},
        "second_call": len(reported),
        "same": again == stamps,
    }
