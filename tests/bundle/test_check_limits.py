"""The process that checks a bundle has limits, so that it ends also when nobody is left to stop it."""

from __future__ import annotations

import json
import subprocess
import sys


def test_the_check_has_limits_on_memory_and_computing() -> None:
    code = (
        "import resource, sys, tsr_engine.bundle.check as check\n"
        "limits = lambda *_: [resource.getrlimit(one) for one in (resource.RLIMIT_AS, resource.RLIMIT_CPU)]\n"
        "check.answer = limits\n"
        "check.main(sys.argv[1:])"
    )
    memory = 2**33
    done = subprocess.run(
        [sys.executable, "-c", code, "b.zip", "folder", "1000", str(memory), "77"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout) == [[memory, memory], [77, 77]]
