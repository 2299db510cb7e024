"""A data folder with one tracked toy drive, a second, empty one, and a bundle to move between them."""

from __future__ import annotations

from tests.app.bundles.toy_bundle import bundled, server

__all__ = ["bundled", "server"]
