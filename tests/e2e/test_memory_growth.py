"""A page that stays open for days does not grow."""

from __future__ import annotations

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page

HELD = """async () => {
  const {loadingState} = await import('/static/js/views/placeholders.js');
  const held = new Set();
  const signal = new AbortController().signal;
  const [add, remove] = [signal.addEventListener.bind(signal), signal.removeEventListener.bind(signal)];
  signal.addEventListener = (name, listener, options) => (held.add(listener), add(name, listener, options));
  signal.removeEventListener = (name, listener) => (held.delete(listener), remove(name, listener));
  const begun = [];
  for (let i = 0; i < 3; i++) {
    loadingState('Loading', {signal, slowAfterMs: 5});
    begun.push(held.size);
  }
  await new Promise((resolve) => setTimeout(resolve, 200));
  return [begun, held.size];
}"""
"""Listeners on the signal of a page: while three views wait, and later."""


def test_a_view_that_was_waited_for_is_not_kept(page: Page) -> None:
    assert page.evaluate(HELD) == [[1, 2, 3], 0]
