"""Makes the shared toys importable."""

from tests.app.evidence_fixtures import home, server_of_copy, toy_homes

__all__ = ["home", "server_of_copy", "toy_homes"]
