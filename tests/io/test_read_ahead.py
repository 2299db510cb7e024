"""Work ahead of its consumer comes in order, with its errors, and ends when the consumer leaves."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Iterator

import pytest

from tsr_engine.io.read_ahead import read_ahead


def threads() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name == "tsr-read-ahead"]


def test_everything_comes_in_order() -> None:
    assert list(read_ahead(lambda: iter(range(50)), 3)) == list(range(50))
    assert not threads()


@pytest.mark.timeout(20)
def test_a_failed_start_is_raised_without_blocking() -> None:
    def make() -> Iterator[int]:
        raise OSError("the file is gone")

    with pytest.raises(OSError, match="the file is gone"):
        next(read_ahead(make, 2))
    assert not threads()


def test_an_error_comes_after_the_items_before_it() -> None:
    def items() -> Iterator[int]:
        yield from (1, 2)
        raise ValueError("damaged")

    seen = []
    with pytest.raises(ValueError, match="damaged"):
        seen.extend(read_ahead(items, 5))
    got = read_ahead(items, 5)
    assert [next(got), next(got)] == [1, 2]
    with pytest.raises(ValueError, match="damaged"):
        next(got)
    assert not threads()


def test_leaving_early_stops_the_work() -> None:
    closed = threading.Event()

    def items() -> Iterator[int]:
        try:
            k = 0
            while True:
                yield k
                k += 1
        finally:
            closed.set()

    got = read_ahead(items, 2)
    assert next(got) == 0
    got.close()  # type: ignore[attr-defined]
    assert closed.is_set()
    assert not threads()


def test_a_depth_of_zero_is_refused() -> None:
    with pytest.raises(ValueError, match="at least 1"):
        next(read_ahead(lambda: iter(()), 0))


def test_the_thread_ends_with_the_process() -> None:
    """A thread inside a library at interpreter exit aborts the process: "exception not rethrown"."""
    script = """
import itertools, time
from tsr_engine.io.read_ahead import read_ahead

def endless():
    try:
        yield from itertools.count()
    finally:
        time.sleep(0.2)
        print("closed", flush=True)

kept = read_ahead(endless, 2)
next(kept)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "closed\n", "")
