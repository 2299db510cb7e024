"""Connects to a Ray cluster."""

from __future__ import annotations

from typing import Any

from tsr_engine.errors import UsageError
from tsr_engine.extras import explained

__all__ = ["ClusterUnreachable", "connect"]


class ClusterUnreachable(UsageError):
    """Raised if no Ray cluster answers at the address."""


def connect(address: str | None, *, start_local: bool) -> Any:  # Any: mypy does not follow Ray
    """Connect to Ray and return the module ``ray``.

    Args:
        address: ``HOST:PORT`` of a cluster's client server; None: the cluster that this machine is part of.
        start_local: whether to start a cluster of this machine alone if the machine is in none.

    Raises:
        MissingExtra: Ray is not installed.
        Unreachable: the cluster cannot be reached.
    """
    with explained():
        import ray
    options = {"log_to_driver": False, "logging_level": "ERROR"}
    try:
        if address is not None:
            ray.init(address=f"ray://{address}", logging_level="ERROR")
        else:
            try:
                ray.init(address="auto", **options)
            except ConnectionError:
                if not start_local:
                    raise
                ray.init(**options, include_dashboard=False)
    except (ConnectionError, ValueError, RuntimeError, TimeoutError) as error:
        cluster_name = "of this machine" if address is None else address
        message = (str(error).splitlines() or [type(error).__name__])[0]
        raise ClusterUnreachable(f"The Ray cluster {cluster_name} cannot be reached: {message.rstrip('.')}.") from None
    return ray
