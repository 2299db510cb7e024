"""What the tests of attacks share: the toy server and homes of ``tests/app``."""

from __future__ import annotations

import sys
from pathlib import Path

_APP = Path(__file__).parents[1] / "app"
sys.path[:0] = [str(Path(__file__).parent), str(_APP), str(_APP / "exchange"), str(_APP / "bundles")]
