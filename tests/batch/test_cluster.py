"""A Ray cluster that does not answer is reported at once; Ray itself tries for a quarter of an hour."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from tsr_engine.batch import cluster
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


@pytest.fixture
def silent(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """An address at which something accepts connections and never answers."""
    monkeypatch.setattr(cluster, "CONNECT_TIMEOUT_S", 0.3)
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"127.0.0.1:{server.getsockname()[1]}"


@pytest.mark.timeout(60)
@pytest.mark.parametrize("is_elsewhere", [False, True])
def test_a_cluster_that_is_silent_is_away(silent: str, monkeypatch: pytest.MonkeyPatch, is_elsewhere: bool) -> None:
    pytest.importorskip("ray", reason="Ray is not installed: pip install 'tsr[cluster]'")
    if not is_elsewhere:
        monkeypatch.setenv("RAY_ADDRESS", silent)
    with pytest.raises(ClusterUnreachable, match=f"cannot be reached: no Ray answers at {silent}"):
        connect(silent if is_elsewhere else None, start_local=False)


@pytest.mark.timeout(60)
def test_the_address_of_a_dead_cluster_is_left(closed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("ray", reason="Ray is not installed: pip install 'tsr[cluster]'")
    monkeypatch.delenv("RAY_ADDRESS", raising=False)
    monkeypatch.setenv("RAY_TMPDIR", str(tmp_path))
    monkeypatch.setattr("ray._private.services.find_gcs_addresses", frozenset)
    (tmp_path / "ray").mkdir()
    (tmp_path / "ray" / "ray_current_cluster").write_text(closed)
    with pytest.raises(ClusterUnreachable, match="The Ray cluster of this machine cannot be reached: nothing listens"):
        connect(None, start_local=False)
