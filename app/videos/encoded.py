"""A cache of encoded pictures in memory; it drops the least recently used first."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Hashable

__all__ = ["EncodedCache"]


class EncodedCache:
    """A thread-safe map from keys to bytes with a maximum size."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._size = 0
        self._held: OrderedDict[Hashable, bytes] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: Hashable) -> bytes | None:
        """Return the bytes of a key, if cached."""
        with self._lock:
            found = self._held.get(key)
            if found is not None:
                self._held.move_to_end(key)
            return found

    def put(self, key: Hashable, data: bytes) -> None:
        """Cache bytes; the least recently used ones are dropped."""
        with self._lock:
            old = self._held.pop(key, None)
            self._size += len(data) - (0 if old is None else len(old))
            self._held[key] = data
            while self._size > self._most and len(self._held) > 1:
                _, dropped = self._held.popitem(last=False)
                self._size -= len(dropped)

    def __contains__(self, key: Hashable) -> bool:
        with self._lock:
            return key in self._held

    @property
    def size(self) -> int:
        """Bytes held."""
        return self._size
