"""The server's secret, one-time links to the page, and the cookie that a link is exchanged for."""

from __future__ import annotations

import hashlib
import hmac
import os
import secrets
import threading
from pathlib import Path

from tsr_engine.errors import StorageError

_MAX_LINKS = 32


def home_token(home: Path) -> str:
    """Return the secret of a data folder, made on first use; only its owner can read the file.

    Raises:
        StorageError: the file cannot be written or is damaged.
    """
    path = home / "token"
    try:
        home.mkdir(parents=True, exist_ok=True)
        try:
            descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        except FileExistsError:
            token = path.read_text(encoding="ascii").strip()
            if len(token) < 16:
                raise StorageError(f"{path} holds no secret of at least 16 characters. Delete it.") from None
            return token
        token = secrets.token_urlsafe(32)
        with os.fdopen(descriptor, "w", encoding="ascii") as file:
            file.write(token + "\n")
            file.flush()
            os.fsync(file.fileno())
    except (OSError, UnicodeDecodeError) as error:
        raise StorageError(f"Cannot keep the server's secret in {path}: {error}. Choose another --home.") from None
    return token


class Tokens:
    """Checks credentials. The cookie is derived from the secret, so it outlives a restart of the server."""

    def __init__(self, secret: str) -> None:
        self._secret = secret.encode()
        self.cookie = hmac.new(self._secret, b"cookie of the page", hashlib.sha256).hexdigest()
        self._links: dict[str, None] = {}
        self._lock = threading.Lock()

    def new_link(self) -> str:
        """Make a secret that opens the page once."""
        link = secrets.token_urlsafe(24)
        with self._lock:
            self._links[link] = None
            while len(self._links) > _MAX_LINKS:
                self._links.pop(next(iter(self._links)))
        return link

    def use_link(self, link: str) -> bool:
        """Whether the link was valid; it is used up now."""
        with self._lock:
            found = next((known for known in self._links if hmac.compare_digest(known.encode(), link.encode())), None)
            return found is not None and self._links.pop(found, 0) is None

    def accepts(self, *, bearer: str | None = None, cookie: str | None = None) -> bool:
        """Whether one of the credentials is valid."""
        by_token = bearer is not None and hmac.compare_digest(bearer.encode(), self._secret)
        by_cookie = cookie is not None and hmac.compare_digest(cookie.encode(), self.cookie.encode())
        return by_token or by_cookie
