"""Entry point of the command `tsr`: Ctrl-C prints one sentence also while the commands are being loaded."""

from __future__ import annotations

import sys


def run() -> int:
    """Run the command line of this process and return its exit code."""
    try:
        from app.cli.main import run as run_commands
    except KeyboardInterrupt:
        sys.stderr.write("tsr: Interrupted.\n")
        return 130
    return run_commands()
