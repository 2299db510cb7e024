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
from tests.app.jobs.office import FRAMES, make_office
from tsr_engine.batch.on_node import run_on_node
from tsr_engine.batch.run_order import RunOrder
from tsr_engine.errors import TsrError
from tsr_engine.params import Params
from tsr_engine.runs.track_video import RunRequest

HOME = Path(sys.argv[1])


def main() -> None:
    """Run and kill; cancel; request models missing from a node."""
    office = make_office(HOME, executor="ray", cores=1)
    office.supervising = Supervisor
    office.open()
    run = office.start()
    waited = office.wait(lambda: office.run(run).state == "running")  # the cluster starts later
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "include_dashboard": False})
    os.environ["RAY_ADDRESS"] = cluster.address
    office.close()
    office.open()  # its workers know the address
    node = cluster.add_node(num_cpus=1)

    def far(row: Run) -> bool:
        assert row.state in ("queued", "running"), (row.state, row.error)
        return 32 < row.frames_done < FRAMES - 16

    office.wait(lambda: far(office.run(run)))
    cluster.remove_node(node, allow_graceful=False)
    cluster.add_node(num_cpus=1)
    office.ended(run)
    job = office.job(run)

    stopped = office.start()
    office.wait(lambda: office.run(stopped).frames_done > 0)
    office.context.runs.cancel(stopped)
    office.ended(stopped, "cancelled")
    office.close()

    refused = ""
    order = RunOrder(RunRequest(SHIPPED[0].video, Params()), None, {"detector": "0" * 64})
    try:
        run_on_node(order, None, lambda _: None, lambda: False)
    except TsrError as error:
        refused = f"{type(error).__name__}: {error}"
    cluster.shutdown()
    said = {"waited": bool(waited), "folder": str(office.evidence(run)), "tokens": job.token, "refused": refused}
    print(json.dumps(said | {"ends": job.payload["ends"], "crashes": job.crashes}))
    office.context.close()


if __name__ == "__main__":
    main()
