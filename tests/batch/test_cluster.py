"""A Ray cluster that does not answer is reported at once; Ray itself tries for a quarter of an hour."""

from __future__ import annotations

import socket

import pytest

from tsr_engine.batch.cluster import ClusterUnreachable, connect


@pytest.fixture
def closed() -> str:
    """An address at which nothing listens."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return f"127.0.0.1:{server.getsockname()[1]}"


@pytest.mark.timeout(60)
@pytest.mark.parametrize("start_local", [False, True])
def test_the_cluster_of_this_machine_is_away(closed: str, monkeypatch: pytest.MonkeyPatch, start_local: bool) -> None:
    pytest.importorskip("ray", reason="Ray is not installed: pip install 'tsr[cluster]'")
    monkeypatch.setenv("RAY_ADDRESS", closed)
    with pytest.raises(ClusterUnreachable, match="The Ray cluster of this machine cannot be reached: .*refused"):
        connect(None, start_local=start_local)


@pytest.mark.timeout(60)
def test_a_cluster_elsewhere_is_away(closed: str) -> None:
    pytest.importorskip("ray", reason="Ray is not installed: pip install 'tsr[cluster]'")
    with pytest.raises(ClusterUnreachable, match=f"The Ray cluster {closed} cannot be reached: .*refused"):
        connect(closed, start_local=False)
