"""A process that writes made-up evidence until it is killed or its disk is full; run by the crash tests.

Usage: write_forever.py FOLDER LIMIT_BYTES. Each line on standard output is the last committed frame.
"""

from __future__ import annotations

import importlib.util
import resource
import sys
from pathlib import Path

from tsr_engine.errors import StorageError
from tsr_engine.evidence import EvidenceWriter

spec = importlib.util.spec_from_file_location("made_up", Path(__file__).with_name("conftest.py"))
assert spec is not None
assert spec.loader is not None
made_up = importlib.util.module_from_spec(spec)
spec.loader.exec_module(made_up)

folder, limit = Path(sys.argv[1]), int(sys.argv[2])
header = made_up.new_header()
begin = EvidenceWriter.resume if (folder / "run.json").exists() else EvidenceWriter.create
writer = begin(folder, header, chunk=5)
if limit:
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
k = -1 if writer.last_frame is None else writer.last_frame
try:
    while True:
        k += 1
        writer.append(made_up.new_frame(k, tracks=k % 3))
        if not writer._pending:
            print(k, flush=True)
except StorageError as error:
    print(error, file=sys.stderr)
    sys.exit(error.exit_code)
