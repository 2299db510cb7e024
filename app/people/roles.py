"""Roles and their rights."""

from __future__ import annotations

from typing import Final, Literal, get_args

Role = Literal["viewer", "annotator", "reviewer", "admin"]
"""Roles in ascending order; each may do everything that those before it may."""
ROLES: Final[tuple[Role, ...]] = get_args(Role)


def at_least(role: Role, min_role: Role) -> bool:
    """Whether a role includes the rights of ``min_role``."""
    return ROLES.index(role) >= ROLES.index(min_role)


def role_of(text: str) -> Role:
    """Return a role by its name.

    Raises:
        ValueError: no such role; the sentence lists them.
    """
    found = next((role for role in ROLES if role == text), None)
    if found is None:
        raise ValueError(f"Expected one of the roles {', '.join(ROLES)}, got {text[:80]!r}.")
    return found
