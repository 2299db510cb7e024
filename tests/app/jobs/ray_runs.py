"""Runs on two Ray nodes, one killed during a run. Run as a script, it prints the outcomes."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

from ray.cluster_utils import Cluster

from app.jobs.supervisor import Supervisor
from app.storage.models import Run
from sample_videos import SHIPPED
from tests.app.jobs.job_server import FRAMES, make_job_server
from tests.waiting import wait_until
from tsr_engine.batch.node_runner import run_on_node
from tsr_engine.batch.node_task import NodeTask
from tsr_engine.errors import TsrError
from tsr_engine.params import Params
from tsr_engine.runs.track_video import RunRequest

HOME = Path(sys.argv[1])


def main() -> None:
    """Run and kill; cancel; request models missing from a node."""
    job_server = make_job_server(HOME, executor="ray", cores=1)
    job_server.supervising = Supervisor
    job_server.open()
    run = job_server.start()
    waited = wait_until(lambda: job_server.run(run).state == "running")  # the cluster starts later
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "include_dashboard": False})
    os.environ["RAY_ADDRESS"] = cluster.address
    job_server.close()
    job_server.open()  # its workers know the address
    node = cluster.add_node(num_cpus=1)

    def far(row: Run) -> bool:
        assert row.state in ("queued", "running"), (row.state, row.error)
        return 32 < row.frames_done < FRAMES - 16

    wait_until(lambda: far(job_server.run(run)))
    cluster.remove_node(node, allow_graceful=False)
    cluster.add_node(num_cpus=1)
    job_server.ended(run)
    job = job_server.job(run)

    stopped = job_server.start()
    wait_until(lambda: job_server.run(stopped).frames_done > 0)
    job_server.context.runs.cancel(stopped)
    job_server.ended(stopped, "cancelled")
    job_server.close()

    refused = ""
    order = NodeTask(RunRequest(SHIPPED[0].video, Params()), None, {"detector": "0" * 64})
    try:
        run_on_node(order, None, lambda _: None, lambda: False)
    except TsrError as error:
        refused = f"{type(error).__name__}: {error}"
    cluster.shutdown()
    said = {"waited": bool(waited), "folder": str(job_server.evidence(run)), "tokens": job.token, "refused": refused}
    print(json.dumps(said | {"ends": job.payload["ends"], "crashes": job.crashes}))
    job_server.context.close()


if __name__ == "__main__":
    main()
