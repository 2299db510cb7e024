"""What browser tests have in common: patience, a browser, a desk with the sample drive and a page on it.

A check waits long, because the machine may be slow; it still ends as soon as it holds. A file that needs another desk
or page makes its own by the same name.
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

    from tests.e2e.review_desk import Desk

PATIENCE = 30_000
"""The longest wait of an expectation, ms."""
LONGEST = 600
"""Time limit of a walk without a limit of its own, s."""
STEP = 0.05
"""Time slice of a slowed server, s."""

if importlib.util.find_spec("playwright") is not None:
    from playwright.sync_api import expect

    expect.set_options(timeout=PATIENCE)


FAILED = pytest.StashKey[bool]()
"""Whether a browser test has failed in some phase."""


def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark each walk as slow, limit its time, and skip it where there is no browser.

    A walk that fails runs once more, and the summary names it: on a busy machine a browser may be late once.
    """
    item.add_marker(pytest.mark.slow)
    item.add_marker(pytest.mark.skipif(not CHROMIUM.is_file(), reason=f"{CHROMIUM} is not installed"))
    if item.get_closest_marker("timeout") is None:
        item.add_marker(pytest.mark.timeout(LONGEST))
    item.add_marker(pytest.mark.flaky(reruns=1))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Note that a browser test has failed."""
    report = yield
    item.stash[FAILED] = report.failed or (report.when != "setup" and item.stash[FAILED])
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> Generator[None, object, object]:
    """What a failed walk leaves half done ends with it: its second run, and the next walk, begin at a new desk.

    The browsers end with the last walk, too, or with one that failed.
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
    """Pages and servers compute as many times slower as ``TSR_SLOWDOWN`` says.

    What fails then takes a moment for granted.
    """
    if not os.environ.get("TSR_SLOWDOWN"):
        yield
        return
    from playwright.sync_api import Browser, BrowserContext

    from tests.e2e.live_server import LiveServer
    from tests.e2e.review_desk import SLOWED

    def slowed(make: Callable[..., Page]) -> Callable[..., Page]:
        def made(*given: object, **named: object) -> Page:
            page = make(*given, **named)
            page.context.new_cdp_session(page).send("Emulation.setCPUThrottlingRate", {"rate": SLOWED})
            return page

        return made

    def start(server: LiveServer, port: int = 0) -> None:
        begin(server, port)
        threading.Thread(target=_limp, args=(os.pidfd_open(server.pid), SLOWED), daemon=True).start()

    begin = LiveServer.start
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(LiveServer, "start", start)
        for owner in (Browser, BrowserContext):
            patch.setattr(owner, "new_page", slowed(owner.new_page))
        yield


def _limp(process: int, slowed: float) -> None:
    """Let a process run only part of the time, until it ends."""
    with suppress(ProcessLookupError):
        while True:
            for send, seconds in ((signal.SIGSTOP, STEP * (slowed - 1)), (signal.SIGCONT, STEP)):
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
    from tests.e2e.browsers import kept_window

    return kept_window(browser)


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    """The first frames of the sample drive, tracked."""
    from tests.e2e.review_desk import open_desk

    with open_desk(tmp_path_factory, SHIPPED[0].video, 120) as desk:
        yield desk


@pytest.fixture
def page(desk: Desk) -> Iterator[Page]:
    """A page on the desk that ends without an error."""
    from tests.e2e.review_desk import faultless

    with faultless(desk.page(shared=True)) as page:
        yield page
