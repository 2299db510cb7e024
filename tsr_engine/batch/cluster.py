"""Connects to a Ray cluster."""

from __future__ import annotations

import os
import socket
from typing import Any, Final

from tsr_engine.errors import UsageError
from tsr_engine.extras import explained

__all__ = ["ClusterUnreachable", "connect"]

_CONNECT_TIMEOUT_S: Final = 5.0
"""Seconds that the port of a cluster may take to answer."""
_HEAD_TRIES: Final = "1"
"""Tries of Ray to reach the head of a cluster, 40 s each; its own 20 would block a run for a quarter of an hour."""


class ClusterUnreachable(UsageError):
    """Raised if no Ray cluster answers at the address."""


def connect(address: str | None, *, start_local: bool) -> Any:  # Any: mypy does not follow Ray
    """Connect to Ray and return the module ``ray``.

    Args:
        address: ``HOST:PORT`` of a cluster's client server; None: the cluster that this machine is part of.
        start_local: whether to start a cluster of this machine alone if the machine is in none.

    Raises:
        MissingExtra: Ray is not installed.
        ClusterUnreachable: the cluster cannot be reached.
    """
    if not start_local:
        os.environ.setdefault("RAY_NUM_REDIS_GET_RETRIES", _HEAD_TRIES)  # read when Ray is imported
    with explained():
        import ray
    options = {"log_to_driver": False, "logging_level": "ERROR"}
    try:
        _require_answer(address or os.environ.get("RAY_ADDRESS", ""))
        if address is not None:
            ray.init(address=f"ray://{address}", logging_level="ERROR")
        else:
            try:
                ray.init(address="auto", **options)
            except ConnectionError:
                if not start_local:
                    raise
                ray.init(**options, include_dashboard=False)
    except (OSError, ValueError, RuntimeError) as error:
        cluster_name = "of this machine" if address is None else address
        message = (str(error).splitlines() or [type(error).__name__])[0]
        raise ClusterUnreachable(f"The Ray cluster {cluster_name} cannot be reached: {message.rstrip('.')}.") from None
    return ray


def _require_answer(address: str) -> None:
    """Check that something listens at ``HOST:PORT``, because Ray tries for long; other addresses are not checked.

    Raises:
        OSError: nothing does.
    """
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if host and port.isdecimal():
        socket.create_connection((host.strip("[]"), int(port)), _CONNECT_TIMEOUT_S).close()
