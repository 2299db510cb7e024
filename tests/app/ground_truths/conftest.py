"""Makes the shared toys importable."""

from tests.app.evidence_fixtures import home, long_runs, toy_homes

__all__ = ["home", "long_runs", "toy_homes"]
