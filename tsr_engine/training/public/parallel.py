"""Processes items on all cores; the result does not depend on their number."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from typing import TypeVar

import numpy as np

from tsr_engine.detection.boosting import training_threads
from tsr_engine.training.progress import Progress

__all__ = ["map_on_cores"]

Item = TypeVar("Item")
Made = TypeVar("Made")

_QUEUED_PER_CORE = 2
"""Items per core that are started ahead; their results wait in memory."""


def map_on_cores(
    work: Callable[[Item, np.random.Generator], Made],
    items: Sequence[Item],
    rng: np.random.Generator,
    progress: Progress,
    stage: str,
) -> Iterator[Made]:
    """Yield the result of ``work`` for each item, in order.

    Each item has its own random numbers, so neither the number of cores nor their speed changes a result.

    Args:
        work: called in several threads at once; only compiled code and OpenCV's run in parallel.
        items: the items to process.
        rng: generator from which each item's generator is made.
        progress: called with each finished item.
        stage: name of the stage for ``progress``.
    """
    generators = rng.spawn(len(items))
    count = training_threads()
    if count == 1:
        for number, made in enumerate(map(work, items, generators)):
            progress(stage, number, len(items))
            yield made
        return
    with ThreadPoolExecutor(count, "tsr-train") as pool:
        waiting = iter(zip(items, generators, strict=True))
        futures = deque(pool.submit(work, *arguments) for arguments in islice(waiting, _QUEUED_PER_CORE * count))
        for number in range(len(items)):
            made = futures.popleft().result()
            progress(stage, number, len(items))
            yield made
            futures.extend(pool.submit(work, *arguments) for arguments in islice(waiting, 1))
