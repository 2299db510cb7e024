"""What browser tests have in common: patience, a browser, a desk with the sample drive and a page on it.

A check waits long, because the machine may be slow; it still ends as soon as it holds. A file that needs another desk
or page makes its own by the same name.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from sample_videos import SHIPPED

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.e2e.review_desk import Desk

PATIENCE = 30_000
"""How long an expectation waits at most, ms."""

if importlib.util.find_spec("playwright") is not None:
    from playwright.sync_api import expect

    expect.set_options(timeout=PATIENCE)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Chromium."""
    from playwright.sync_api import sync_playwright

    from tests.e2e.screenshots import CHROMIUM, FLAGS

    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield running
        running.close()


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    """The first frames of the sample drive, tracked."""
    from tests.e2e.review_desk import open_desk

    with open_desk(tmp_path_factory, SHIPPED[0].video, {"stop": 120}) as desk:
        yield desk


@pytest.fixture
def page(desk: Desk) -> Iterator[Page]:
    """A page on the desk that ends without an error."""
    from tests.e2e.review_desk import faultless

    with faultless(desk.page()) as page:
        yield page
