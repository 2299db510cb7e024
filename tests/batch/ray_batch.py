"""Two Ray nodes on this machine, one killed during a batch. Run as a script, it prints the outcome."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

from ray.cluster_utils import Cluster

from tsr_engine.batch.manifest import Identity
from tsr_engine.batch.run import BatchProgress, BatchRequest, run_batch
from tsr_engine.batch.task import DriveTask
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components
from tsr_engine.version import __version__

DRIVES, OUT = Path(sys.argv[1]), Path(sys.argv[2])


def main() -> None:
    """Run, kill, run again."""
    params = Params().with_settings([("coast_foe_y", 0.5)])
    digests = dict(load_components(params).models)
    parameters = params.model_dump(mode="json")
    request = BatchRequest(
        sorted(DRIVES.glob("*.mp4")),
        OUT,
        Identity(__version__, parameters, digests),
        DriveTask("", "", parameters, digests=digests),
        "ray",
    )
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    other = cluster.add_node(num_cpus=1)
    os.environ["RAY_ADDRESS"] = cluster.address
    killed_after: list[int] = []

    def kill_one(at: BatchProgress) -> None:
        if not killed_after:
            killed_after.append(at.done)
            cluster.remove_node(other, allow_graceful=False)

    manifest = run_batch(request, kill_one, lambda: False)
    stamps = {str(p): p.stat().st_mtime_ns for p in OUT.glob("*/**/*")}
    reported: list[BatchProgress] = []
    run_batch(request, reported.append, lambda: False)
    again = {str(p): p.stat().st_mtime_ns for p in OUT.glob("*/**/*")}
    cluster.shutdown()
    print(
        json.dumps(
            {
                "killed_after": killed_after,
                "states": {drive.folder: [drive.state, drive.error] for drive in manifest.drives},
                "second_call": len(reported),
                "same": again == stamps,
            }
        )
    )


if __name__ == "__main__":
    main()
