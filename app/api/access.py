"""Identifies the caller: a dependency of every route, which also checks the role."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final

from fastapi import Depends
from starlette.requests import HTTPConnection
from starlette.routing import Route

from app.api.roles import least_role
from app.context import Context
from app.people.identity import Identity
from app.security.access import identity_of

__all__ = ["EVERYBODY", "Who", "WhoDep", "authorise", "operation_of"]

EVERYBODY: Final = frozenset({"sign_in", "login", "sign_in_page", "index", "icon"})
"""Operations that need nobody: they are the way in."""


@dataclass(frozen=True, slots=True)
class Who:
    """Who is asking, and the name that their changes carry."""

    identity: Identity
    otherwise: str

    def author(self, said: str | None) -> str:
        """The name that a change carries.

        Args:
            said: the name that the request gives.

        Raises:
            Refused: it is somebody else's.
        """
        return self.identity.author(said, self.otherwise)

    def reader(self, said: str | None) -> str:
        """Whose operations are read."""
        return self.identity.reader(said, self.otherwise)


def operation_of(route: Route) -> str:
    """The name of a route's operation: that of the OpenAPI document, else that of its function."""
    return str(getattr(route, "operation_id", None) or route.endpoint.__name__)


async def authorise(connection: HTTPConnection) -> None:
    """Refuse what the role of who is asking may not do; a dependency of the whole application.

    It only looks at what is known already, so it needs no turn in a thread, as a plain function would have.

    Raises:
        Refused: it may not.
    """
    operation = operation_of(connection.scope["route"])
    if operation not in EVERYBODY:
        identity_of(connection).require(least_role(operation))


async def _who(connection: HTTPConnection) -> Who:
    context: Context = connection.app.state.context
    return Who(identity_of(connection), context.settings.author)


WhoDep = Annotated[Who, Depends(_who)]
"""A route's parameter of this type says who is asking."""
