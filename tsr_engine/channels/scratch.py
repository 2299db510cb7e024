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

MAX_CACHED_VIEWS: Final = 1000
"""Number of cached views: enough for a dozen picture sizes."""


class Scratch:
    """Named arrays, made on first use. Threads must not share a ``Scratch``."""

    def __init__(self) -> None:
        self._buffers: dict[str, NDArray[np.uint8]] = {}
        self._views: dict[tuple[str, tuple[int, ...], type], NDArray[Any]] = {}  # Any: of the type in the key

    def array(self, name: str, shape: tuple[int, ...], dtype: type[T]) -> NDArray[T]:
        """An uninitialised contiguous array; it shares memory with earlier arrays of the same name."""
        key = (name, shape, dtype)
        view = self._views.get(key)
        if view is None:
            size = math.prod(shape) * np.dtype(dtype).itemsize
            buffer = self._buffers.get(name)
            if buffer is None or buffer.nbytes < size:
                buffer = self._buffers[name] = np.empty(size, np.uint8)
                self._views = {known: kept for known, kept in self._views.items() if known[0] != name}
            elif len(self._views) >= MAX_CACHED_VIEWS:
                self._views.clear()
            view = self._views[key] = buffer[:size].view(dtype).reshape(shape)
        return view
