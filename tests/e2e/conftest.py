"""What browser tests have in common: time limits, a browser, a server with the sample drive and a page on it.

A check waits long, because the machine may be slow; it still ends as soon as it holds. A file that needs another
server or page makes its own by the same name.
"""

from __future__ import annotations

import importlib.util
import os
import signal
import threading
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import suppress
from typing import TYPE_CHECKING

import pytest

from sample_videos import SHIPPED
from tests.e2e.chromium import CHROMIUM

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Page

    from tests.e2e.review_session import ReviewSession

EXPECT_TIMEOUT_MS = 30_000
"""The longest wait of an expectation, ms."""
MAX_TEST_S = 600
"""Time limit of a test that sets none, s."""
SLOWDOWN_STEP_S = 0.05
"""Time slice of a slowed server, s."""

if importlib.util.find_spec("playwright") is not None:
    from playwright.sync_api import expect

    expect.set_options(timeout=EXPECT_TIMEOUT_MS)


FAILED = pytest.StashKey[bool]()
"""Whether a browser test has failed in some phase."""


def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark each test as slow, limit its time, and skip it where there is no browser.

    A failed test runs once more, and the summary names it: on a busy machine a browser may be late once.
    """
    item.add_marker(pytest.mark.slow)
    item.add_marker(pytest.mark.skipif(not CHROMIUM.is_file(), reason=f"{CHROMIUM} is not installed"))
    if item.get_closest_marker("timeout") is None:
        item.add_marker(pytest.mark.timeout(MAX_TEST_S))
    item.add_marker(pytest.mark.flaky(reruns=1))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Note that a browser test has failed."""
    report = yield
    item.stash[FAILED] = report.failed or (report.when != "setup" and item.stash[FAILED])
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> Generator[None, object, object]:
    """Tear all fixtures down after a failure: the rerun and the next test begin on a new server.

    The browsers close after the last test, or after a failure.
    """
    try:
        if item.stash[FAILED]:
            item.session._setupstate.teardown_exact(item.session)
    finally:
        done = yield
        if item.stash[FAILED] or nextitem is None or nextitem.path.parent != item.path.parent:
            from tests.e2e.browsers import close_browsers

            close_browsers()
    return done


@pytest.fixture(scope="session", autouse=True)
def slowdown() -> Iterator[None]:
    """Slow down pages and servers by the factor ``TSR_SLOWDOWN``.

    What fails then takes a moment for granted.
    """
    if not os.environ.get("TSR_SLOWDOWN"):
        yield
        return
    from playwright.sync_api import Browser, BrowserContext

    from tests.e2e.live_server import LiveServer
    from tests.e2e.review_session import SLOWDOWN

    def slowed(make: Callable[..., Page]) -> Callable[..., Page]:
        def made(*given: object, **named: object) -> Page:
            page = make(*given, **named)
            page.context.new_cdp_session(page).send("Emulation.setCPUThrottlingRate", {"rate": SLOWDOWN})
            return page

        return made

    def start(server: LiveServer, port: int = 0) -> None:
        begin(server, port)
        threading.Thread(target=_throttle, args=(os.pidfd_open(server.pid), SLOWDOWN), daemon=True).start()

    begin = LiveServer.start
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(LiveServer, "start", start)
        for owner in (Browser, BrowserContext):
            patch.setattr(owner, "new_page", slowed(owner.new_page))
        yield


def _throttle(process: int, slowed: float) -> None:
    """Let a process run only part of the time, until it ends."""
    with suppress(ProcessLookupError):
        while True:
            for send, seconds in ((signal.SIGSTOP, SLOWDOWN_STEP_S * (slowed - 1)), (signal.SIGCONT, SLOWDOWN_STEP_S)):
                signal.pidfd_send_signal(process, send)
                time.sleep(seconds)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Chromium."""
    from tests.e2e.browsers import open_browser

    with open_browser() as running:
        yield running


@pytest.fixture(scope="module")
def window(browser: Browser) -> BrowserContext:
    """State that the pages of a file share; ``fresh_page`` makes a page."""
    from tests.e2e.browsers import shared_window

    return shared_window(browser)


@pytest.fixture(scope="module")
def review(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ReviewSession]:
    """The first frames of the sample drive, tracked."""
    from tests.e2e.review_session import open_session

    with open_session(tmp_path_factory, SHIPPED[0].video, 120) as review:
        yield review


@pytest.fixture
def page(review: ReviewSession) -> Iterator[Page]:
    """A page on the review that ends without an error."""
    from tests.e2e.review_session import without_errors

    with without_errors(review.page(shared=True)) as page:
        yield page
