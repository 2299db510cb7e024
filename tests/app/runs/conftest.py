"""Makes the shared toys importable."""

from tests.app.evidence_fixtures import home, long_runs, server_of_copy, toy_homes

__all__ = ["home", "long_runs", "server_of_copy", "toy_homes"]
