"""Import all modules that the processes of a server load: those of all jobs, and those of sandboxes.

Rerun's SDK is left out: importing it starts threads, which a process forked later would lack. A standby worker would
load it for more than a second of CPU per server; here the first recording loads it.
"""

from __future__ import annotations

import app.bundles.checking
import app.exchange.sandboxed_imports
import app.jobs.worker
import app.main
import app.storage.migrate
import app.videos.decoding  # noqa: F401
import tsr_engine.recording.write
from app.follows.task import warm
from app.job_kinds import KINDS
from tsr_engine.pipeline import one_opencv_thread

__all__: list[str] = []

tsr_engine.recording.write.load_sdk = lambda: None
for kind in KINDS:
    kind.load()
with one_opencv_thread():
    warm()
