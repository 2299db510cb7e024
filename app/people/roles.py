"""Roles and their rights."""

from __future__ import annotations

from typing import Final, Literal, get_args

__all__ = ["ROLES", "Role", "at_least", "role_of"]

Role = Literal["viewer", "annotator", "reviewer", "admin"]
"""Each may do what those before it may."""
ROLES: Final[tuple[Role, ...]] = get_args(Role)


def at_least(role: Role, least: Role) -> bool:
    """Whether a role may do what needs ``least``."""
    return ROLES.index(role) >= ROLES.index(least)


def role_of(text: str) -> Role:
    """A role by its name.

    Raises:
        ValueError: there is none of that name; the sentence lists them.
    """
    found = next((role for role in ROLES if role == text), None)
    if found is None:
        raise ValueError(f"Expected one of the roles {', '.join(ROLES)}, got {text[:80]!r}.")
    return found
