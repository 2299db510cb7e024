"""Shared parts of the commands that compare parameter values, on videos that no reported figure uses."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import cv2

from benchmarks.experiment import Skip
from tsr_engine.errors import TsrError


def choice_parser(name: str, about: str | None) -> argparse.ArgumentParser:
    """A command line with the common options: further settings, and the folder for detections.

    Args:
        name: name of the module in ``benchmarks``.
        about: docstring of the module.
    """
    parser = argparse.ArgumentParser(
        prog=f"python -m benchmarks.{name}", description=about, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--setting", action="append", default=[], help="a further configuration")
    parser.add_argument("--scratch", type=Path, help="folder that keeps detections for the next call")
    return parser


def print_report(name: str, scratch: Path | None, compute: Callable[[Path], str]) -> int:
    """Print the result of a command, or one sentence that says why there is none; returns the exit code.

    Args:
        name: name of the module, printed before that sentence.
        scratch: folder for detections; unset: a temporary one.
        compute: computes the text, given the folder.
    """
    cv2.setNumThreads(1)
    try:
        with tempfile.TemporaryDirectory() as folder:
            sys.stdout.write(compute(scratch or Path(folder)))
    except (TsrError, Skip) as error:
        sys.stderr.write(f"{name}: {error}\n")
        return 1
    return 0
