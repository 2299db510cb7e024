"""Patience in the browser: a check waits long, because the machine may be slow; it still ends as soon as it holds."""

from __future__ import annotations

import importlib.util

PATIENCE = 30_000
"""How long an expectation waits at most, ms."""

if importlib.util.find_spec("playwright") is not None:
    from playwright.sync_api import expect

    expect.set_options(timeout=PATIENCE)
