"""Tokens and sessions: random secrets; the database stores only their hashes."""

from __future__ import annotations

import hashlib
import secrets
from typing import Final

_PREFIX: Final = "tsr_"
"""Prefix that marks tokens, for people and for scanners of leaked secrets."""
_MAX_LENGTH: Final = 200


def new_secret() -> str:
    """Make a token of 256 random bits."""
    return _PREFIX + secrets.token_urlsafe(32)


def hash_of(secret: str) -> str:
    """Return the hash that is stored of a secret; the secret has too many random bits to be guessed from it."""
    return hashlib.sha256(secret[: _MAX_LENGTH + 1].encode()).hexdigest()
