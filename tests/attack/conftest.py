"""The attack on the server as tests: what it did, in seconds. The tools are those of ``tests/app``."""

from tests.app.conftest import cluster, home, server

__all__ = ["cluster", "home", "server"]
