"""What the processes of a server load, loaded by importing this module: all kinds of jobs, and what cages do."""

from __future__ import annotations

import app.bundles.checking
import app.exchange.caged
import app.jobs.worker
import app.main
import app.storage.migrating
import app.videos.decoding  # noqa: F401
from app.kinds import KINDS

__all__: list[str] = []

for kind in KINDS:
    kind.load()
