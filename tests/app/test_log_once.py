"""The error of a loop is logged once, and only an unexpected one with its traceback."""

from __future__ import annotations

import logging

import pytest

from app.files.store import SharedFilesError
from app.log_once import LogOnce


@pytest.mark.parametrize(
    ("error", "traceback"),
    [
        (SharedFilesError("The shared files do not answer."), False),
        (OSError("no room"), False),
        (ValueError("a fault"), True),
    ],
)
def test_an_error_is_one_line_until_it_is_over(
    caplog: pytest.LogCaptureFixture, error: Exception, traceback: bool
) -> None:
    once = LogOnce(logging.getLogger("tsr.test"), "Files cannot be shared")
    for _ in range(2):
        once.failed(error)
    once.recovered()
    once.recovered()
    failed, over = caplog.records
    assert failed.getMessage() == f"Files cannot be shared: {str(error).rstrip('.')}. It is tried again."
    assert (failed.exc_info is not None) is traceback
    assert over.getMessage() == "Files cannot be shared: that is over."
