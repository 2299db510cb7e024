"""Headers of a trusted reverse proxy: the caller's name, and that the connection to it is TLS.

Only the address of the connection itself decides whether a proxy is trusted, never one in a header.
"""

from __future__ import annotations

import ipaddress
from collections.abc import Iterable

from starlette.datastructures import Headers
from starlette.types import Scope


class BadProxyHeader(Exception):
    """A request has an invalid proxy header, or one that it may not have; the text is a sentence."""


class Proxies:
    """The trusted proxies.

    Args:
        networks: addresses and networks of proxies, such as ``10.0.0.7`` or ``10.0.0.0/24``.
        header: header in which such a proxy names the person.
    """

    def __init__(self, networks: Iterable[str], header: str) -> None:
        self._networks = tuple(ipaddress.ip_network(text) for text in networks)
        self._header = header.lower().encode("latin-1")
        self.header = header

    def person(self, scope: Scope) -> str | None:
        """The person that a trusted proxy names; None: the request has no such header.

        Raises:
            BadProxyHeader: the sender is no trusted proxy, or the header appears twice.
        """
        values = [value for name, value in scope["headers"] if name == self._header]
        if not values:
            return None
        if not self._trusts(scope):
            raise BadProxyHeader(
                f"The request names a person in the header {self.header}, but {_peer(scope)} is no trusted proxy. Add "
                "it to TSR_TRUSTED_PROXIES, or leave the header out."
            )
        if len(values) > 1:
            raise BadProxyHeader(f"The proxy sent the header {self.header} {len(values)} times. It must send it once.")
        try:
            return values[0].decode("utf-8").strip() or None
        except UnicodeDecodeError:
            raise BadProxyHeader(f"The proxy's header {self.header} is not UTF-8.") from None

    def is_tls(self, scope: Scope) -> bool:
        """Whether the browser uses TLS, with us or with a proxy on this machine or in the list."""
        if scope["scheme"] in ("https", "wss"):
            return True
        values = Headers(scope=scope).get("x-forwarded-proto", "")
        return values.split(",")[0].strip().lower() in ("https", "wss") and (_is_loopback(scope) or self._trusts(scope))

    def _trusts(self, scope: Scope) -> bool:
        address = _address(scope)
        return address is not None and any(address in network for network in self._networks)


def _peer(scope: Scope) -> str:
    return str((scope.get("client") or ("an unknown address",))[0])


def _address(scope: Scope) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        address = ipaddress.ip_address(_peer(scope))
    except ValueError:
        return None
    mapped = address.ipv4_mapped if isinstance(address, ipaddress.IPv6Address) else None
    return mapped or address


def _is_loopback(scope: Scope) -> bool:
    address = _address(scope)
    return address is not None and address.is_loopback
