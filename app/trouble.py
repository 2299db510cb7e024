"""Logs what keeps a loop from its work, such as a full disk, once for each different error."""

from __future__ import annotations

import logging

from sqlalchemy.exc import DBAPIError

__all__ = ["Trouble"]


class Trouble:
    """The trouble of one loop.

    Args:
        log: where it is told.
        what: what does not work meanwhile; begins a sentence.
    """

    def __init__(self, log: logging.Logger, what: str) -> None:
        self._log = log
        self._what = what
        self._told: str | None = None

    def came(self, error: Exception) -> None:
        """Tell it, if it is not what was told last. What nobody expected is told with its traceback."""
        text = str(error.orig) if isinstance(error, DBAPIError) else str(error)
        if text != self._told:
            self._told = text
            expected = isinstance(error, DBAPIError | OSError)
            self._log.warning("%s: %s. It is tried again.", self._what, text, exc_info=None if expected else error)

    def gone(self) -> None:
        """It works again."""
        if self._told is not None:
            self._told = None
            self._log.warning("%s: that is over.", self._what)
