"""The caller: the user of a library without people, the server's own secret, or a person."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from app.errors import Refused
from app.people.roles import Role, at_least

__all__ = ["OWNER", "SECRET", "Identity"]


@dataclass(frozen=True, slots=True)
class Identity:
    """Who a request comes from.

    Attributes:
        role: what it may do.
        person: id of the account; None: the library has no people, or the request carries the server's own secret.
        name: of the account.
        credential: hash of the token or session, which can be revoked; None: it has none.
        owner: the library has no people: names of authors are free.
    """

    role: Role
    person: str | None = None
    name: str | None = None
    credential: str | None = None
    owner: bool = False

    def require(self, least: Role) -> None:
        """Refuse what the role may not do.

        Raises:
            Refused: it may not.
        """
        if not at_least(self.role, least):
            article = "an" if self.role[0] in "aeiou" else "a"
            raise Refused(
                f"{self.name} is {article} {self.role}; this needs the role {least}. Ask an administrator.",
                code="role",
                details={"role": self.role, "least": least},
            )

    def author(self, said: str | None, otherwise: str) -> str:
        """The name that a change carries.

        Args:
            said: the name that the request gives; None: it gives none.
            otherwise: the name in a library without people, where none is given.

        Raises:
            Refused: it is the name of somebody else, or nobody is signed in.
        """
        if self.owner:
            return said or otherwise
        if self.name is None:
            raise Refused(
                "The server's own secret belongs to no person, so nothing can be changed in its name. Use a token of "
                "'tsr people token'.",
                code="no_person",
            )
        if said is not None and said != self.name:
            raise Refused(
                f"This change was made by {said!r}, but {self.name!r} is signed in. It can be saved when {said!r} "
                "signs in.",
                code="other_name",
            )
        return self.name

    def reader(self, said: str | None, otherwise: str) -> str:
        """Whose operations are asked for: in a library with people always one's own."""
        if self.owner:
            return said or otherwise
        return self.name or ""


OWNER: Final = Identity("admin", owner=True)
"""The user of a library without people."""
SECRET: Final = Identity("admin")
"""A program with the server's own secret, in a library with people."""
