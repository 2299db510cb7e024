"""A data folder with one tracked toy drive, a second one that knows nothing of it, and a bundle between them."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parent))

from bundle_office import bundled, server
from evidence_fixtures import home, long_runs, toy_homes

__all__ = ["bundled", "home", "long_runs", "server", "toy_homes"]
