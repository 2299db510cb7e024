"""Decodes pictures for a view in a thread, so that a slow seek does not block the scene."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
_log = logging.getLogger("tsr.scene3d")


class PictureLoader:
    """Decodes the frame that was requested last.

    Args:
        decode: returns frame k as RGB; None: not available.
        ready: called from another thread when a picture is ready.
    """

    def __init__(self, decode: Callable[[int], Image | None], ready: Callable[[], None]) -> None:
        self._decode = decode
        self._ready = ready
        self._changed = threading.Condition()
        self._requested: int | None = None
        self._loaded: tuple[int, Image | None] | None = None
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="tsr-space-pictures", daemon=True)
        self._thread.start()

    def get(self, frame: int, seconds: float) -> tuple[bool, Image | None]:
        """Request a frame and wait for it.

        Returns:
            Whether the result is known after so many seconds, and the picture. If it is not known, ``ready`` is called
            later, unless another frame is requested first.
        """
        with self._changed:
            if self._loaded is None or self._loaded[0] != frame:
                self._requested = frame
                self._changed.notify_all()
                self._changed.wait_for(lambda: self._is_loaded(frame) or self._ended, seconds)
            return (True, self._loaded[1]) if self._loaded is not None and self._is_loaded(frame) else (False, None)

    def stop(self) -> None:
        """End the thread without waiting for the current frame."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def _is_loaded(self, frame: int) -> bool:
        return self._loaded is not None and self._loaded[0] == frame

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._ended or self._requested is not None)
                if self._ended or self._requested is None:
                    return
                frame, self._requested = self._requested, None
            try:
                picture = self._decode(frame)
            except Exception:
                _log.exception("Frame %s of a 3-D view could not be decoded.", frame)
                picture = None
            with self._changed:
                self._loaded = frame, picture
                self._changed.notify_all()
            self._ready()
