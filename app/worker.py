"""A process that does jobs: ``python -m app.worker PARENT LANE [stay]``; see :mod:`app.jobs.worker`."""

from __future__ import annotations

import sys

from app.job_kinds import KINDS
from app.jobs.worker import main

if __name__ == "__main__":
    sys.exit(main(KINDS, sys.argv[1:]))
