"""Caches answers about whole runs; concurrent requests share one computation."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable

__all__ = ["Answers"]

CACHE_BYTES = 48 * 2**20
"""Maximum memory of all answers, bytes."""


class Answers:
    """Answers by key (kind of answer, run, state of the run); thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._known: OrderedDict[tuple[str, ...], bytes] = OrderedDict()
        self._turns: dict[tuple[str, ...], threading.Lock] = {}

    def get(self, key: tuple[str, ...], make: Callable[[], bytes]) -> bytes:
        """Return the answer of a key, computing it if needed; it replaces the answer for an earlier state."""
        with self._lock:
            turn = self._turns.setdefault(key, threading.Lock())
        with turn:  # concurrent requests wait for the first one's answer
            with self._lock:
                known = self._known.get(key)
                if known is not None:
                    self._known.move_to_end(key)
                    return known
            try:
                answer = make()
            finally:
                with self._lock:
                    self._turns.pop(key, None)
            self._keep(key, answer)
            return answer

    def forget(self, run_id: str) -> None:
        """Drop the answers of a run."""
        with self._lock:
            for key in [key for key in self._known if key[1] == run_id]:
                del self._known[key]

    def _keep(self, key: tuple[str, ...], answer: bytes) -> None:
        with self._lock:
            for old in [k for k in self._known if k[:2] == key[:2]]:
                del self._known[old]
            self._known[key] = answer
            while len(self._known) > 1 and sum(map(len, self._known.values())) > CACHE_BYTES:
                self._known.popitem(last=False)
