"""Makes the shared toys importable."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from evidence_fixtures import home, server_of_copy, toy_homes

__all__ = ["home", "server_of_copy", "toy_homes"]
