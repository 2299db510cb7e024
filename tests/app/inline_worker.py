"""Runs jobs in this process at once, without a worker."""

from __future__ import annotations

from app.context import Context
from app.job_kinds import KINDS
from app.jobs.context import TaskContext
from app.jobs.outcome import report_failure
from app.jobs.worker import perform
from tsr_engine.errors import TsrError


def run_jobs(context: Context, *kinds: str) -> None:
    """Run all waiting jobs, or those of some kinds."""
    while True:
        with context.database.read() as session:
            waiting = context.jobs.waiting_ids(session)
        for job_id in waiting:
            with context.database.write() as session:
                job = context.jobs.claim(session, job_id)
            assert job is not None
            if kinds and job.kind not in kinds:
                with context.database.write() as session:
                    context.jobs.release(session, job.id, job.token)
                continue
            task = TaskContext(context.settings, context.database, context.events, context.jobs, job, lambda: False)
            try:
                perform(task, KINDS)
            except TsrError as error:
                report_failure(task, str(error))
            break
        else:
            return
