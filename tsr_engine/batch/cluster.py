"""Connects to a Ray cluster."""

from __future__ import annotations

import os
import socket
from types import ModuleType
from typing import Any, Final

from tsr_engine.errors import UsageError
from tsr_engine.extras import explained

CONNECT_TIMEOUT_S: Final = 5.0
"""Seconds that the port of a cluster may take to answer."""
_GREETING: Final = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + b"\0\0\0\4\0\0\0\0\0"
"""Beginning of a connection in HTTP/2, which Ray's servers speak; they answer it at once (RFC 9113, 3.4)."""
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
        if address is not None:
            _require_answer(address)
            ray.init(address=f"ray://{address}", logging_level="ERROR")
        else:
            _require_answer(os.environ.get("RAY_ADDRESS", ""))
            try:
                _require_answer(_address_of_this_machine(ray))
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


def _address_of_this_machine(ray: ModuleType) -> str:
    """The address at which Ray looks for the cluster of this machine; it stays behind when the cluster dies.

    Raises:
        ConnectionError: there is none.
    """
    # it is private, so other versions of Ray may lack it
    find = getattr(ray._private.services, "canonicalize_bootstrap_address_or_die", None)
    return "" if find is None else str(find("auto"))


def _require_answer(address: str) -> None:
    """Check that a server of Ray answers at ``HOST:PORT``, because Ray tries for long; other addresses are not checked.

    Raises:
        ConnectionError: none does.
        OSError: there is no such host.
    """
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if not host or not port.isdecimal():
        return
    try:
        with socket.create_connection((host.strip("[]"), int(port)), CONNECT_TIMEOUT_S) as connection:
            if os.environ.get("RAY_USE_TLS", "0") != "0":
                return  # Ray's server waits for a handshake of TLS
            connection.sendall(_GREETING)
            answers = bool(connection.recv(1))
    except ConnectionRefusedError:
        raise ConnectionError(f"nothing listens at {address}, the connection is refused") from None
    except (TimeoutError, ConnectionError):
        answers = False
    if not answers:
        raise ConnectionError(f"no Ray answers at {address}")
