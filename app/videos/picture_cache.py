"""A cache of encoded pictures in memory; it drops the least recently used first."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Hashable


class PictureCache:
    """A thread-safe map from keys to bytes with a maximum size."""

    def __init__(self, max_bytes: int) -> None:
        self._max_bytes = max_bytes
        self._size = 0
        self._entries: OrderedDict[Hashable, bytes] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: Hashable) -> bytes | None:
        """Return the bytes of a key, if cached."""
        with self._lock:
            data = self._entries.get(key)
            if data is not None:
                self._entries.move_to_end(key)
            return data

    def put(self, key: Hashable, data: bytes) -> None:
        """Cache bytes; the least recently used ones are dropped."""
        with self._lock:
            old = self._entries.pop(key, None)
            self._size += len(data) - (0 if old is None else len(old))
            self._entries[key] = data
            while self._size > self._max_bytes and len(self._entries) > 1:
                _, dropped = self._entries.popitem(last=False)
                self._size -= len(dropped)

    def __contains__(self, key: Hashable) -> bool:
        with self._lock:
            return key in self._entries

    @property
    def size(self) -> int:
        """Bytes held."""
        return self._size
