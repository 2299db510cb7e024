"""What the commands have in common that tell which values to choose, on videos that no figure is reported on."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import cv2

from benchmarks.experiment import Skip
from tsr_engine.errors import TsrError

__all__ = ["choice_parser", "report"]


def choice_parser(name: str, about: str | None) -> argparse.ArgumentParser:
    """The command line with what every such command has: further settings, and where detections are kept.

    Args:
        name: of the module in ``benchmarks``.
        about: its docstring.
    """
    parser = argparse.ArgumentParser(
        prog=f"python -m benchmarks.{name}",
        description=about,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--setting", action="append", default=[], help="a further configuration")
    parser.add_argument("--scratch", type=Path, help="where detections are kept for the next call")
    return parser


def report(name: str, scratch: Path | None, tell: Callable[[Path], str]) -> int:
    """Print what a command has to tell, or one sentence that says why it cannot; the exit code.

    Args:
        name: of the module, before that sentence.
        scratch: folder for detections; unset: one for this call.
        tell: that folder -> the text.
    """
    cv2.setNumThreads(1)
    try:
        with tempfile.TemporaryDirectory() as folder:
            sys.stdout.write(tell(scratch or Path(folder)))
    except (TsrError, Skip) as error:
        sys.stderr.write(f"{name}: {error}\n")
        return 1
    return 0
