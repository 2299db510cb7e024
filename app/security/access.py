"""Identifies the caller of a request from tokens, cookies and proxy headers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Final, cast

import anyio
import anyio.to_thread
from starlette.datastructures import Headers
from starlette.requests import HTTPConnection, Request
from starlette.responses import Response
from starlette.types import Scope

from app.people.directory import SESSION_DAYS, Directory
from app.people.identity import OWNER, SECRET, Identity
from app.security.proxies import BadProxyHeader, Proxies
from app.security.tokens import Tokens

_KEY: Final = "tsr.identity"
_MAX_QUERIES: Final = 16
"""Maximum number of requests that query the database for their caller at once."""


def cookie_name(port: int) -> str:
    """Name of the cookie; it contains the port, because browsers do not separate cookies by port."""
    return f"tsr_{port}"


def identity_of(connection: HTTPConnection) -> Identity:
    """Return the caller of a request that the guard has accepted."""
    return cast(Identity, connection.scope[_KEY])


def sign_in_cookie(request: Request, answer: Response, secret: str, days: int = SESSION_DAYS) -> None:
    """Set a cookie that scripts cannot read and other sites cannot send; 0 days: delete it."""
    port = (request.scope.get("server") or ("", 0))[1] or 0
    origin = request.headers.get("origin", "")
    answer.set_cookie(
        cookie_name(port),
        secret,
        max_age=days * 86400,
        httponly=True,
        samesite="strict",
        # a TLS proxy need not announce itself, so trust the browser's scheme too
        secure=request.url.scheme == "https" or origin.startswith("https://"),
    )


class Denied(Exception):
    """A request without valid credentials.

    Attributes:
        status: 401 or 403.
        code: word for programs.
        message: sentence for people.
    """

    def __init__(self, status: int, code: str, message: str) -> None:
        super().__init__(message)
        self.status, self.code, self.message = status, code, message


@dataclass(frozen=True, slots=True)
class _Credentials:
    """Credentials of a request."""

    bearer: str | None
    cookies: tuple[str, ...]
    proxy_person: str | None
    """Person that a trusted proxy names."""


class Access:
    """Identifies the callers of requests.

    Args:
        tokens: the server's own secret.
        directory: the people of the library.
        proxies: proxies that may name a person in a header.
    """

    def __init__(self, tokens: Tokens, directory: Directory, proxies: Proxies) -> None:
        self.tokens = tokens
        self.directory = directory
        self.proxies = proxies
        self._limit = anyio.CapacityLimiter(_MAX_QUERIES)

    async def authenticate(self, scope: Scope) -> None:
        """Store the caller of a request for :func:`identity_of`.

        Raises:
            Denied: the credentials are missing or invalid.
        """
        scope[_KEY] = await self.identify(scope)

    async def identify(self, scope: Scope) -> Identity:
        """Return the caller of a request.

        Raises:
            Denied: the credentials are missing or invalid.
        """
        if self.directory.is_known_empty:
            return self._owner(scope)
        return await anyio.to_thread.run_sync(self._find_identity, scope, limiter=self._limit)

    async def has_no_people(self) -> bool:
        """Whether the library has no people."""
        return self.directory.is_known_empty or await anyio.to_thread.run_sync(
            self.directory.is_empty, limiter=self._limit
        )

    async def has_access(self, identity: Identity) -> bool:
        """Whether a caller who was accepted still has access."""
        return await anyio.to_thread.run_sync(self.directory.has_access, identity, limiter=self._limit)

    def _find_identity(self, scope: Scope) -> Identity:
        if self.directory.had_people:
            # Finding a person shows that the library has people: one query instead of two.
            with suppress(Denied):
                identity = self._person(scope)
                if identity.person is not None:
                    return identity
        return self._owner(scope) if self.directory.is_empty() else self._person(scope)

    def _owner(self, scope: Scope) -> Identity:
        credentials = self._credentials(scope, people=False)
        by_cookie = any(self.tokens.accepts(cookie=cookie) for cookie in credentials.cookies)
        if by_cookie or self.tokens.accepts(bearer=credentials.bearer):
            return OWNER
        raise Denied(401, "unauthorised", "Open the link that the terminal shows ('tsr review' prints a new one).")

    def _person(self, scope: Scope) -> Identity:
        credentials = self._credentials(scope, people=True)
        if credentials.proxy_person is not None:
            person = self.directory.by_name(credentials.proxy_person)
            if person is None:
                raise Denied(
                    401,
                    "no_account",
                    f"The proxy names {credentials.proxy_person[:80]!r}, who has no account here. "
                    "An administrator can add it ('tsr people add').",
                )
            return person
        if credentials.bearer is not None:
            if self.tokens.accepts(bearer=credentials.bearer):
                return SECRET
            person, revoked = self.directory.by_secret(credentials.bearer, "token")
            if person is None:
                raise Denied(401, *_bad_token(revoked))
            return person
        for cookie in credentials.cookies:
            person, _ = self.directory.by_secret(cookie, "session")
            if person is not None:
                return person
        raise Denied(401, "signed_out", "You are not signed in, or no longer. Sign in to continue.")

    def _credentials(self, scope: Scope, *, people: bool) -> _Credentials:
        headers = Headers(scope=scope)
        kind, _, bearer = headers.get("authorization", "").partition(" ")
        server = scope.get("server") or ("", 0)
        name = cookie_name(server[1] or 0)
        try:
            proxy_person = self.proxies.person(scope) if people else None
        except BadProxyHeader as error:
            raise Denied(403, "bad_proxy", str(error)) from None
        return _Credentials(
            bearer=bearer.strip() if kind.lower() == "bearer" else None,
            cookies=tuple(c for header in headers.getlist("cookie") for c in _cookies(header, name)),
            proxy_person=proxy_person,
        )


def _bad_token(revoked: bool) -> tuple[str, str]:
    if revoked:
        return "revoked", "This token has been revoked. Ask an administrator for a new one ('tsr people rotate')."
    return "unauthorised", "This token is wrong. Ask an administrator for a new one ('tsr people rotate')."


def _cookies(header: str, name: str) -> Iterator[str]:
    """All cookies with a name. Other programs on this machine may set cookies of any form for the same host."""
    for part in header.split(";"):
        key, equals, value = part.strip().partition("=")
        if equals and key == name:
            yield value
