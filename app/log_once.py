"""Logs an error that stops a loop, such as a full disk, once for each different error."""

from __future__ import annotations

import logging

from sqlalchemy.exc import DBAPIError

from tsr_engine.errors import TsrError


class LogOnce:
    """Logs the errors of one loop, once for each different error.

    Args:
        log: the logger.
        what: the operation that fails meanwhile; begins the sentence.
    """

    def __init__(self, log: logging.Logger, what: str) -> None:
        self._log = log
        self._what = what
        self._reported: str | None = None

    def failed(self, error: Exception) -> None:
        """Log an error unless it was logged last; unexpected ones with their traceback."""
        text = str(error.orig) if isinstance(error, DBAPIError) else str(error)
        if text != self._reported:
            self._reported = text
            expected = isinstance(error, DBAPIError | OSError | TsrError)
            self._log.warning(
                "%s: %s. It is tried again.", self._what, text.rstrip("."), exc_info=None if expected else error
            )

    def recovered(self) -> None:
        """Log that the operation works again."""
        if self._reported is not None:
            self._reported = None
            self._log.warning("%s: that is over.", self._what)
