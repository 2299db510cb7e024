"""The command `tsr` with toy parts in place of trained models: ``toy_cli.py [--delay S] ARGUMENTS...``."""

from __future__ import annotations

import sys

import tsr_engine.pipeline
from tests import toy_pipeline
from tsr_engine.cli.main import run


def main() -> int:
    arguments, delay = sys.argv[1:], 0.0
    if arguments[:1] == ["--delay"]:
        delay, arguments = float(arguments[1]), arguments[2:]
    tsr_engine.pipeline.load_components = lambda params, folder=None, network=None: toy_pipeline.components(
        params, delay
    )
    return run(arguments)


if __name__ == "__main__":
    sys.exit(main())
