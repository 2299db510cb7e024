"""The progress of training."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Progress", "named"]

Progress = Callable[[str, int, int], None]
"""Called with the name of a stage, the number of its steps that are done, and their total."""


def named(what: str, progress: Progress) -> Progress:
    """Progress whose stages begin with ``what``."""
    return lambda stage, done, total: progress(f"{what}: {stage}", done, total)
