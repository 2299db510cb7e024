"""The caller: the user of a library without people, the server's own secret, or a person."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from app.errors import Refused
from app.people.roles import Role, at_least


@dataclass(frozen=True, slots=True)
class Identity:
    """The caller of a request.

    Attributes:
        role: its role.
        person: id of the account; None: the library has no people, or the request carries the server's own secret.
        name: name of the account.
        credential: hash of the token or session, which can be revoked; None: there is none.
        owner: the library has no people, so that any author name is allowed.
    """

    role: Role
    person: str | None = None
    name: str | None = None
    credential: str | None = None
    owner: bool = False

    def require(self, min_role: Role) -> None:
        """Refuse a caller with a lower role.

        Raises:
            Refused: the role is too low.
        """
        if not at_least(self.role, min_role):
            article = "an" if self.role[0] in "aeiou" else "a"
            raise Refused(
                f"{self.name} is {article} {self.role}; this needs the role {min_role}. Ask an administrator.",
                code="role",
                details={"role": self.role, "least": min_role},
            )

    def author(self, requested: str | None, default: str) -> str:
        """Return the name that a change carries.

        Args:
            requested: the name in the request; None: there is none.
            default: the default name in a library without people.

        Raises:
            Refused: the name belongs to another person, or nobody is signed in.
        """
        if self.owner:
            return requested or default
        if self.name is None:
            raise Refused(
                "The server's own secret belongs to no person, so it cannot change anything. Use a token of "
                "'tsr people token'.",
                code="no_person",
            )
        if requested is not None and requested != self.name:
            raise Refused(
                f"This change was made by {requested!r}, but {self.name!r} is signed in. It can be saved when "
                f"{requested!r} signs in.",
                code="other_name",
            )
        return self.name

    def reader(self, requested: str | None, default: str) -> str:
        """Return the person whose operations are read: in a library with people always the caller."""
        if self.owner:
            return requested or default
        return self.name or ""


OWNER: Final = Identity("admin", owner=True)
"""The user of a library without people."""
SECRET: Final = Identity("admin")
"""A program with the server's own secret, in a library with people."""
