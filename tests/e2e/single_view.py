"""Views without a server: an empty page imports their modules, and the test answers their requests."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from playwright.sync_api import Browser, Page, Route

__all__ = ["empty_page", "result"]

FILES = Path(__file__).parents[2]
"""The folder with ``static``."""

PARTS = """
const load = (module) => import(`/static/js/views/${module}`);
const { signal } = new AbortController();
/** Until all answers that are there have been shown. */
const settle = () => new Promise((resolve) => setTimeout(resolve, 50));
/** A request whose answer the test chooses later. */
const later = () => Promise.withResolvers();
const buttonOf = (root, text) => [...root.querySelectorAll('button')].find((one) => one.textContent.includes(text));
/** An app with a state; `dispatched` holds the arguments of its actions. */
const stub = (state, api, more = {}) => {
  const dispatched = [];
  const store = { get: () => state, dispatch: (_, ...args) => dispatched.push(...args) };
  return { store, api, signal, dispatched, load: async (request) => request(), ...more };
};
const session = { person: { name: 'Rolf', role: 'reviewer' } };
const worker = (name) => ({ name, role: 'annotator', decided: 1, rejected: 0, hours: 1, assigned: 0, in_review: 0 });
const change = { author: 'Anna', time: '2026-11-21T06:00:00Z', name: 'set_review', frame: null, differences: [] };
const inspected = (key) => ({ entry: { key }, doc: { revision: 1 }, review: { run: { id: 'r' }, unsaved: [] } });
"""


@contextmanager
def empty_page(browser: Browser) -> Iterator[Page]:
    """An empty page that can import the modules of the page."""
    page = browser.new_page()
    page.route("**/*", _answer)
    page.goto("http://localhost/")
    yield page
    page.close()


def _answer(route: Route) -> None:
    """Answer a request by a file, and others by an empty page."""
    file = FILES / urlsplit(route.request.url).path.lstrip("/")
    if file.is_file():
        route.fulfill(path=file)
    else:
        route.fulfill(body="<!doctype html>", content_type="text/html")


def result(page: Page, body: str) -> Any:
    """What a function with this body returns in the page."""
    return page.evaluate(f"async () => {{ {PARTS} {body} }}")
