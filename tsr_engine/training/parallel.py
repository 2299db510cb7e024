"""Processes items on all cores; the result does not depend on their number."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np

from tsr_engine.detection.boosting import training_threads

__all__ = ["map_on_cores"]

Item = TypeVar("Item")
Made = TypeVar("Made")

_QUEUED_PER_CORE = 2
"""Items per core that are started ahead; their results wait in memory."""


def map_on_cores(
    work: Callable[[Item, np.random.Generator], Made], items: Sequence[Item], rng: np.random.Generator
) -> Iterator[Made]:
    """Yield the result of ``work`` for each item, in order.

    Each item has its own random numbers, so neither the number of cores nor their speed changes a result.

    Args:
        work: called in several threads at once; only compiled code and OpenCV's run in parallel.
        items: the items to process.
        rng: generator from which each item's generator is made.
    """
    generators = rng.spawn(len(items))
    count = training_threads()
    if count == 1:
        yield from map(work, items, generators)
        return
    with ThreadPoolExecutor(count, "tsr-train") as pool:
        futures = [
            pool.submit(work, *arguments)
            for arguments in zip(items[: _QUEUED_PER_CORE * count], generators, strict=False)
        ]
        for number in range(len(items)):
            yield futures[number].result()
            futures[number] = None  # type: ignore[call-overload]
            next_item = len(futures)
            if next_item < len(items):
                futures.append(pool.submit(work, items[next_item], generators[next_item]))
