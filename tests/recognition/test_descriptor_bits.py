"""A freshly compiled kernel gives the same bits as a cached one."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import hashlib
import numpy as np
from tsr_engine.recognition.descriptor import SIDE, describe_patches

noise = np.random.default_rng(5).integers(0, 256, (40, SIDE, SIDE, 3), dtype=np.uint8)
print(hashlib.sha256(describe_patches(noise).tobytes()).hexdigest())
"""


@pytest.mark.slow
def test_two_processes_give_the_same_descriptor(tmp_path: Path) -> None:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    found = [
        subprocess.run(
            [sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True, timeout=240
        ).stdout
        for _ in range(2)
    ]
    assert any(tmp_path.rglob("*.nbc")), "nothing was compiled into the cache"
    assert found[0] == found[1]
