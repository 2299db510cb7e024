"""Arrays that are reused for every picture.

A picture's pyramid takes ten megabytes for a few milliseconds. The operating system would map and clear new pages for
each picture, which takes longer than filling them.
"""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T", bound=np.generic)


class Scratch:
    """Named arrays, made when first asked for; not to be shared by threads."""

    def __init__(self) -> None:
        self._made: dict[str, NDArray[np.uint8]] = {}

    def array(self, name: str, shape: tuple[int, ...], dtype: type[T]) -> NDArray[T]:
        """An uninitialised contiguous array; what was asked for under this name before is overwritten."""
        wanted = math.prod(shape) * np.dtype(dtype).itemsize
        made = self._made.get(name)
        if made is None or made.nbytes < wanted:
            made = self._made[name] = np.empty(wanted, np.uint8)
        return made[:wanted].view(dtype).reshape(shape)
