"""`python -m app` is the command `tsr`: the engine's commands and those of the review tool."""

from __future__ import annotations

import sys

from app.cli.start import run

if __name__ == "__main__":
    sys.exit(run())
