"""Runs and a batch on Ray nodes, which are killed meanwhile.

A cluster takes many processes, so one serves both.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

from app.jobs.supervisor import Supervisor
from app.storage.models import Run
from sample_videos import SHIPPED
from tests.app.jobs.job_server import FRAMES, make_job_server
from tests.batch.ray_batch import run_killed_batch
from tests.waiting import wait_until
from tsr_engine.batch.node_runner import run_on_node
from tsr_engine.batch.node_task import NodeTask
from tsr_engine.errors import TsrError
from tsr_engine.params import Params
from tsr_engine.runs.track_video import RunRequest


def main(arguments: list[str]) -> int:
    """Run and kill; cancel; request models missing from a node; run a batch and kill.

    Args:
        arguments: the data folder, the folder of the batch's drives, and the folder of its results. The outcomes are
            written into ``outcomes.json`` beside the data folder.
    """
    # the process that this one is forked from has not loaded Ray
    from ray.cluster_utils import Cluster

    home, drives, out = map(Path, arguments)
    job_server = make_job_server(home, executor="ray", cores=1)
    job_server.supervising = Supervisor
    job_server.open()
    run = job_server.start()
    waited = wait_until(lambda: job_server.run(run).state == "running")  # the cluster starts later
    head = {"num_cpus": 0, "include_dashboard": False, "include_log_monitor": False, "no_monitor": True}
    cluster = Cluster(initialize_head=True, head_node_args=head)
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

    other = cluster.add_node(num_cpus=1)
    batch = run_killed_batch(drives, out, lambda: cluster.remove_node(other, allow_graceful=False))
    cluster.shutdown()
    outcomes = {
        "waited": bool(waited),
        "folder": str(job_server.evidence(run)),
        "tokens": job.token,
        "refused": refused,
        "ends": job.payload["ends"],
        "crashes": job.crashes,
        "batch": batch,
    }
    home.with_name("outcomes.json").write_text(json.dumps(outcomes))
    job_server.context.close()
    return 0
