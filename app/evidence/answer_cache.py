"""Caches answers about whole runs; concurrent requests share one computation."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable

CACHE_BYTES = 48 * 2**20
"""Maximum memory of all answers, bytes."""


class AnswerCache:
    """Answers by key (kind of answer, run, state of the run); thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._answers: OrderedDict[tuple[str, ...], bytes] = OrderedDict()
        self._key_locks: dict[tuple[str, ...], threading.Lock] = {}

    def get(self, key: tuple[str, ...], make: Callable[[], bytes]) -> bytes:
        """Return the answer of a key, computing it if needed; it replaces the answer for an earlier state."""
        with self._lock:
            key_lock = self._key_locks.setdefault(key, threading.Lock())
        with key_lock:  # concurrent requests wait for the first one's answer
            with self._lock:
                answer = self._answers.get(key)
                if answer is not None:
                    self._answers.move_to_end(key)
                    return answer
            try:
                answer = make()
                self._store(key, answer)  # before the lock goes, or the next request computes it again
            finally:
                with self._lock:
                    self._key_locks.pop(key, None)
            return answer

    def forget(self, run_id: str) -> None:
        """Drop the answers of a run."""
        with self._lock:
            for key in [key for key in self._answers if key[1] == run_id]:
                del self._answers[key]

    def _store(self, key: tuple[str, ...], answer: bytes) -> None:
        with self._lock:
            for stale_key in [k for k in self._answers if k[:2] == key[:2]]:
                del self._answers[stale_key]
            self._answers[key] = answer
            while len(self._answers) > 1 and sum(map(len, self._answers.values())) > CACHE_BYTES:
                self._answers.popitem(last=False)
