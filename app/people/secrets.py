"""Tokens and sessions: random secrets; the database stores only their hashes."""

from __future__ import annotations

import hashlib
import secrets
from typing import Final

__all__ = ["hash_of", "new_secret"]

_PREFIX: Final = "tsr_"
"""Tells a token from other secrets, for people and for programs that look for leaked ones."""
_MOST: Final = 200


def new_secret() -> str:
    """A token of 256 random bits."""
    return _PREFIX + secrets.token_urlsafe(32)


def hash_of(secret: str) -> str:
    """What is stored of a secret; it has too many random bits to be guessed from its hash."""
    return hashlib.sha256(secret[: _MOST + 1].encode()).hexdigest()
