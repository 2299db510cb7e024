"""A data folder with one tracked toy drive, a second, empty one, and a bundle to move between them."""

from __future__ import annotations

from tests.app.bundles.bundle_office import bundled, server
from tests.app.evidence_fixtures import home, long_runs, toy_homes

__all__ = ["bundled", "home", "long_runs", "server", "toy_homes"]
