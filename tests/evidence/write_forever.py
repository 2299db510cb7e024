"""A process that writes made-up evidence until it is killed or its disk is full; run by the crash tests.

Usage: write_forever.py FOLDER LIMIT_BYTES. Each line on standard output is the last committed frame.
"""

from __future__ import annotations

import resource
import sys
from pathlib import Path

from tests.evidence.synthetic_evidence import make_frame, make_header
from tsr_engine.errors import StorageError
from tsr_engine.evidence import EvidenceWriter

folder, limit = Path(sys.argv[1]), int(sys.argv[2])
header = make_header()
begin = EvidenceWriter.resume if (folder / "run.json").exists() else EvidenceWriter.create
writer = begin(folder, header, chunk=5)
if limit:
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
k = -1 if writer.last_frame is None else writer.last_frame
try:
    while True:
        k += 1
        writer.append(make_frame(k, tracks=k % 3))
        if not writer._pending:
            print(k, flush=True)
except StorageError as error:
    print(error, file=sys.stderr)
    sys.exit(error.exit_code)
