"""Arrays that are reused for every picture.

A picture's pyramid takes ten megabytes for a few milliseconds. The operating system would map and clear new pages for
each picture, which takes longer than filling them.
"""

from __future__ import annotations

import math
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T", bound=np.generic)

VIEWS_LIMIT: Final = 1000
"""Number of cached views: enough for a dozen picture sizes."""


class Scratch:
    """Named arrays, made on first use. Threads must not share a ``Scratch``."""

    def __init__(self) -> None:
        self._made: dict[str, NDArray[np.uint8]] = {}
        self._views: dict[tuple[str, tuple[int, ...], type], NDArray[Any]] = {}  # Any: of the type in the key

    def array(self, name: str, shape: tuple[int, ...], dtype: type[T]) -> NDArray[T]:
        """An uninitialised contiguous array; it shares memory with earlier arrays of the same name."""
        key = (name, shape, dtype)
        view = self._views.get(key)
        if view is None:
            wanted = math.prod(shape) * np.dtype(dtype).itemsize
            made = self._made.get(name)
            if made is None or made.nbytes < wanted:
                made = self._made[name] = np.empty(wanted, np.uint8)
                self._views = {known: kept for known, kept in self._views.items() if known[0] != name}
            elif len(self._views) >= VIEWS_LIMIT:
                self._views.clear()
            view = self._views[key] = made[:wanted].view(dtype).reshape(shape)
        return view
