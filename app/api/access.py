"""Identifies the caller: a dependency of every route, which also checks the role."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final

from fastapi import Depends
from starlette.requests import HTTPConnection
from starlette.routing import Route

from app.api.roles import min_role_of
from app.context import Context
from app.people.identity import Identity
from app.security.access import identity_of

EVERYBODY: Final = frozenset({"sign_in", "login", "sign_in_page", "index", "icon"})
"""Operations that need no sign-in, because signing in uses them."""


@dataclass(frozen=True, slots=True)
class Who:
    """The caller of a route, and the author name that their changes carry."""

    identity: Identity
    default_author: str

    def author(self, requested: str | None) -> str:
        """Return the name that a change carries.

        Raises:
            Refused: the name belongs to another person.
        """
        return self.identity.author(requested, self.default_author)

    def reader(self, requested: str | None) -> str:
        """Return the person whose operations the caller may read."""
        return self.identity.reader(requested, self.default_author)


def operation_of(route: Route) -> str:
    """Return the operation id of a route in the OpenAPI document, or else its function's name."""
    return str(getattr(route, "operation_id", None) or route.endpoint.__name__)


async def authorise(connection: HTTPConnection) -> None:
    """Refuse what the caller's role does not allow; a dependency of the whole application.

    It is a coroutine because it only reads memory: a plain function would wait for a thread.

    Raises:
        Refused: the role does not allow the operation.
    """
    operation = operation_of(connection.scope["route"])
    if operation not in EVERYBODY:
        identity_of(connection).require(min_role_of(operation))


async def _who(connection: HTTPConnection) -> Who:
    context: Context = connection.app.state.context
    return Who(identity_of(connection), context.settings.author)


WhoDep = Annotated[Who, Depends(_who)]
"""Parameter type of routes that need the caller."""
